// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

// The part of DuckDB's C interface for extensions, version 1.2.0, that the extension uses. Later versions
// keep it: a table in which every function has a fixed index. Handles are opaque pointers.

namespace alidade::duckdb {

using Handle = void*;

/// The functions that DuckDB passes to an extension when it loads it.
struct ExtensionAccess {
  void (*set_error)(Handle info, const char* message);
  Handle* (*database)(Handle info);
  const void* (*functions)(Handle info, const char* version);
};

/// The beginning of DuckDB's table, copied when the extension is loaded, since
/// DuckDB's own is valid only then.
constexpr std::size_t k_function_count = 274;
inline std::array<const void*, k_function_count> functions{};

template <int index, class Signature>
struct Function;
template <int index, class Result, class... Arguments>
struct Function<index, Result(Arguments...)> {
  Result operator()(Arguments... arguments) const {
    static_assert(index >= 0 && index < static_cast<int>(k_function_count));
    return reinterpret_cast<Result (*)(Arguments...)>(const_cast<void*>(functions[index]))(arguments...);
  }
};

using Index = std::uint64_t;
using Destroy = void (*)(void*);
using Callback = void (*)(Handle info);
using FillCallback = void (*)(Handle info, Handle chunk);
enum class State : int { success = 0, error = 1 };
enum class Type : int { bigint = 5, ubigint = 9, float64 = 11, varchar = 17, blob = 18 };

constexpr Function<3, State(Handle database, Handle* connection)> connect{};
constexpr Function<6, void(Handle* connection)> disconnect{};
constexpr Function<25, void(void*)> free{};
constexpr Function<26, Index()> vector_size{};
constexpr Function<92, void(Handle* value)> destroy_value{};
constexpr Function<130, double(Handle value)> get_double{};
constexpr Function<142, char*(Handle value)> get_varchar{};
constexpr Function<149, bool(Handle value)> is_null_value{};
constexpr Function<156, Handle(Type)> create_logical_type{};
constexpr Function<184, void(Handle* type)> destroy_logical_type{};
constexpr Function<190, Handle(Handle chunk, Index column)> chunk_vector{};
constexpr Function<192, void(Handle chunk, Index rows)> set_chunk_size{};
constexpr Function<194, void*(Handle vector)> vector_data{};
constexpr Function<195, std::uint64_t*(Handle vector)> vector_validity{};
constexpr Function<196, void(Handle vector)> make_validity_writable{};
constexpr Function<198, void(Handle vector, Index row, const char* bytes, Index size)> assign_string{};
constexpr Function<207, void(std::uint64_t* validity, Index row)> set_row_invalid{};
constexpr Function<242, Handle()> create_table_function{};
constexpr Function<243, void(Handle* function)> destroy_table_function{};
constexpr Function<244, void(Handle function, const char* name)> set_name{};
constexpr Function<245, void(Handle function, Handle type)> add_parameter{};
constexpr Function<247, void(Handle function, const void* extra, Destroy)> set_extra_info{};
constexpr Function<248, void(Handle function, Callback)> set_bind{};
constexpr Function<249, void(Handle function, Callback)> set_init{};
constexpr Function<251, void(Handle function, FillCallback)> set_fill{};
constexpr Function<252, void(Handle function, bool)> supports_projection{};
constexpr Function<253, State(Handle connection, Handle function)> register_table_function{};
constexpr Function<254, const void*(Handle info)> bind_extra_info{};
constexpr Function<255, void(Handle info, const char* name, Handle type)> add_result_column{};
constexpr Function<257, Handle(Handle info, Index)> bind_parameter{};
constexpr Function<259, void(Handle info, void* data, Destroy)> set_bind_data{};
constexpr Function<261, void(Handle info, const char* message)> set_bind_error{};
constexpr Function<263, void*(Handle info)> init_bind_data{};
constexpr Function<264, void(Handle info, void* data, Destroy)> set_init_data{};
constexpr Function<265, Index(Handle info)> init_column_count{};
constexpr Function<266, Index(Handle info, Index)> init_column_index{};
constexpr Function<267, void(Handle info, Index)> set_max_threads{};
constexpr Function<268, void(Handle info, const char* message)> set_init_error{};
constexpr Function<270, void*(Handle info)> fill_bind_data{};
constexpr Function<271, void*(Handle info)> fill_init_data{};
constexpr Function<273, void(Handle info, const char* message)> set_fill_error{};

}  // namespace alidade::duckdb
