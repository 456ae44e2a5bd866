// SPDX-License-Identifier: MIT
// DuckDB's extension: cloud files as table functions, pruned as `alidade sql` prunes them.
//   alidade_points(file)
//   alidade_ray(file, ox,oy,oz, dx,dy,dz, radius)            dist_ray <= radius; also columns dist and t
//   alidade_plane(file, px,py,pz, nx,ny,nz, least, largest)  dist_plane in the interval; also column dist
// DuckDB passes no conditions to table functions of this interface (1.5), so only their arguments prune.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/shown_text.h"
#include "database/file_cloud.h"
#include "database/point_cursor.h"
#include "octree/index_file/index_file.h"

namespace alidade::duckdb {

// The part of DuckDB's C interface for extensions, version 1.2.0, that the extension uses. Later versions
// keep it: a table in which every function has a fixed index. Handles are opaque pointers.

using Handle = void*;

/// The functions that DuckDB passes to an extension when it loads it.
struct ExtensionAccess {
  void (*set_error)(Handle info, const char* message);
  Handle* (*database)(Handle info);
  const void* (*functions)(Handle info, const char* version);
};

/// The beginning of DuckDB's table, copied when the extension is loaded: DuckDB's own is valid only then.
constexpr std::size_t k_function_count = 274;
static std::array<const void*, k_function_count> functions{};

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

namespace {

using namespace database;

struct TableFunction {
  const char* name;
  std::optional<DistanceKind> kind;
  Index numbers;  ///< after the file's name
};
constexpr std::array<TableFunction, 3> k_functions = {{{"alidade_points", std::nullopt, 0},
                                                       {"alidade_ray", DistanceKind::ray, 7},
                                                       {"alidade_plane", DistanceKind::plane, 8}}};

/// A cloud shared by scans.
struct SharedCloud {
  explicit SharedCloud(const std::filesystem::path& file) : files(std::span(&file, 1), FileTables{}) {}

  FileCloud files;
  std::mutex mutex;  ///< of its source
};

/// The cloud of a name. That of the last statement remains open, so that the next one need not read it again
/// if the files are unchanged.
std::shared_ptr<SharedCloud> cloud_of(const std::string& name) {
  static std::mutex mutex;
  static std::vector<std::filesystem::path> last_names;
  static std::shared_ptr<SharedCloud> last;
  const std::filesystem::path file = name;
  std::vector<std::filesystem::path> names =
      resolve_clouds(std::span(&file, 1), index_and_file_formats()).names();
  const std::scoped_lock lock(mutex);
  if (last && last_names == names) {
    try {
      last->files.check_unchanged();
      return last;
    } catch (const Error&) {
      last.reset();
    }
  }
  last = std::make_shared<SharedCloud>(name);
  last_names = std::move(names);
  return last;
}

/// A call of a table function.
struct Call {
  const TableFunction* function;
  std::shared_ptr<SharedCloud> cloud;
  ScanFilter filter;

  const CloudSchema& schema() const { return cloud->files.schema(); }
};

/// One scan.
struct Scan {
  std::optional<PointCursor> cursor;
  std::vector<Index> columns;  ///< those requested; numbers beyond the last mean none
};

template <class T>
void destroy(void* object) {
  delete static_cast<T*>(object);
}

/// Runs a callback of DuckDB, through which no exception may pass.
template <class Work, class Fail>
void guarded(Handle info, const Fail& fail, const Work& work) {
  try {
    work();
  } catch (const std::exception& error) {
    fail(info, line_text(error.what()).c_str());
  }
}

std::string text_argument(Handle info, Index number) {
  Handle value = bind_parameter(info, number);
  char* const text = is_null_value(value) ? nullptr : get_varchar(value);
  const std::string kept = text == nullptr ? "" : text;
  free(text);
  destroy_value(&value);
  check_that(!kept.empty(), "missing file name", "the name of a cloud file, folder or pattern");
  return kept;
}

double number_argument(Handle info, Index number) {
  Handle value = bind_parameter(info, number);
  const double kept = is_null_value(value) ? std::nan("") : get_double(value);
  destroy_value(&value);
  check_that(!std::isnan(kept), "argument " + std::to_string(number + 1) + " is NULL or not a number",
             "a number");
  return kept;
}

PointFilter filter_of(const TableFunction& function, Handle info) {
  std::array<double, 8> n{};
  for (Index i = 0; i < function.numbers; ++i) n[i] = number_argument(info, i + 1);
  PointFilter filter;
  if (!function.kind) return filter;
  const Interval limits = *function.kind == DistanceKind::ray ? Interval{0.0, n[6]} : Interval{n[6], n[7]};
  filter.add(*function.kind, make_line(*function.kind, {n[0], n[1], n[2]}, {n[3], n[4], n[5]}), limits);
  return filter;
}

Type type_of(const StoredColumn& column) {
  if (column.type == ScalarType::bytes) return Type::blob;
  if (!column.is_whole()) return Type::float64;
  return column.type == ScalarType::uint64 ? Type::ubigint : Type::bigint;
}

void add_column(Handle info, const std::string& name, Type type) {
  Handle logical = create_logical_type(type);
  add_result_column(info, name.c_str(), logical);
  destroy_logical_type(&logical);
}

void bind(Handle info) {
  guarded(info, set_bind_error, [&] {
    auto call = std::make_unique<Call>();
    call->function = static_cast<const TableFunction*>(bind_extra_info(info));
    call->filter.points = filter_of(*call->function, info);
    call->cloud = cloud_of(text_argument(info, 0));
    const std::vector<StoredColumn>& stored = call->schema().columns;
    add_column(info, stored.front().name, Type::bigint);
    for (const char* const axis : {"x", "y", "z"}) add_column(info, axis, Type::float64);
    for (std::size_t i = 1; i < stored.size(); ++i) add_column(info, stored[i].name, type_of(stored[i]));
    if (call->function->kind) add_column(info, line_column(stored, "dist"), Type::float64);
    if (call->function->kind == DistanceKind::ray) add_column(info, line_column(stored, "t"), Type::float64);
    set_bind_data(info, call.release(), destroy<Call>);
  });
}

void begin(Handle info) {
  guarded(info, set_init_error, [&] {
    const Call& call = *static_cast<const Call*>(init_bind_data(info));
    auto scan = std::make_unique<Scan>();
    for (Index i = 0; i < init_column_count(info); ++i) scan->columns.push_back(init_column_index(info, i));
    set_max_threads(info, 1);
    const std::scoped_lock lock(call.cloud->mutex);
    call.cloud->files.check_unchanged();
    scan->cursor.emplace(call.cloud->files.source(), call.schema(), call.filter, RowOrder::stored);
    set_init_data(info, scan.release(), destroy<Scan>);
  });
}

/// Writes a value into a row of a vector of the column's type.
struct PutValue {
  Handle vector;
  Index row;
  Type type;

  void operator()(std::monostate) const {
    make_validity_writable(vector);
    set_row_invalid(vector_validity(vector), row);
  }
  template <class Number>
  void operator()(Number number) const {
    void* const data = vector_data(vector);
    if (type == Type::float64)
      static_cast<double*>(data)[row] = static_cast<double>(number);
    else
      static_cast<std::uint64_t*>(data)[row] = static_cast<std::uint64_t>(number);
  }
  void operator()(std::span<const std::byte> bytes) const {
    assign_string(vector, row, reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
};

void put(const Call& call, const PointCursor& cursor, Index column, Handle vector, Index row) {
  constexpr Index k_axes = 3;
  const std::vector<StoredColumn>& stored = call.schema().columns;
  const PutValue number{vector, row, Type::float64};
  if (column >= 1 && column <= k_axes) {
    number(cursor.position()[static_cast<int>(column) - 1]);
  } else if (const Index more = column - stored.size() - k_axes; column >= stored.size() + k_axes) {
    if (call.function->kind == DistanceKind::plane && more == 0) {
      number(signed_distance(call.filter.points.planes.front().plane, cursor.position()));
    } else if (call.function->kind == DistanceKind::ray && more < 2) {
      const RayProjection at = *cursor.projection();
      number(more == 0 ? at.distance : at.t);
    }
  } else {
    const StoredColumn& from = stored[column == 0 ? 0 : column - k_axes];
    const Type type = column == 0 ? Type::bigint : type_of(from);
    std::visit(PutValue{vector, row, type},
               stored_value(from, call.cloud->files.source().bytes(cursor.chunk(), from, cursor.row())));
  }
}

void fill(Handle info, Handle chunk) {
  guarded(info, set_fill_error, [&] {
    const Call& call = *static_cast<const Call*>(fill_bind_data(info));
    Scan& scan = *static_cast<Scan*>(fill_init_data(info));
    const std::scoped_lock lock(call.cloud->mutex);
    Index row = 0;
    for (const Index most = vector_size(); row < most && !scan.cursor->at_end(); ++row, scan.cursor->next()) {
      for (Index i = 0; i < scan.columns.size(); ++i)
        put(call, *scan.cursor, scan.columns[i], chunk_vector(chunk, i), row);
    }
    set_chunk_size(chunk, row);
  });
}

bool register_function(Handle connection, const TableFunction& described) {
  Handle function = create_table_function();
  set_name(function, described.name);
  for (Index i = 0; i <= described.numbers; ++i) {
    Handle type = create_logical_type(i == 0 ? Type::varchar : Type::float64);
    add_parameter(function, type);
    destroy_logical_type(&type);
  }
  set_extra_info(function, &described, nullptr);
  set_bind(function, bind);
  set_init(function, begin);
  set_fill(function, fill);
  supports_projection(function, true);
  const bool is_registered = register_table_function(connection, function) == State::success;
  destroy_table_function(&function);
  return is_registered;
}

bool load(Handle info, const ExtensionAccess& access) {
  const void* const table = access.functions(info, "v1.2.0");
  if (table == nullptr) return false;  // DuckDB has reported the error
  static std::once_flag is_copied;
  std::call_once(is_copied, [&] { std::memcpy(functions.data(), table, sizeof functions); });
  Handle connection = nullptr;
  bool is_loaded = connect(*access.database(info), &connection) == State::success;
  for (const TableFunction& function : k_functions)
    is_loaded = is_loaded && register_function(connection, function);
  if (connection != nullptr) disconnect(&connection);
  if (!is_loaded) access.set_error(info, "alidade: cannot register its table functions");
  return is_loaded;
}

}  // namespace
}  // namespace alidade::duckdb

/// The entry point for DuckDB.
extern "C" __attribute__((visibility("default"))) bool alidade_init_c_api(
    void* info, const alidade::duckdb::ExtensionAccess* access) {
  return alidade::duckdb::load(info, *access);
}
