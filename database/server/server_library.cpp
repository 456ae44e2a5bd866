// SPDX-License-Identifier: MIT
#include "database/server/server_library.h"

#include <dlfcn.h>

#include "base/error.h"

namespace alidade {
namespace {

/// The version of the interface, which has been the same since PostgreSQL 8.2.
constexpr const char* k_file = "libpq.so.5";

[[noreturn]] void refuse() {
  const char* const reason = ::dlerror();
  throw Error({.problem = "servers cannot be asked without PostgreSQL's client library",
               .expected = "Debian's package libpq5, or its like",
               .found = reason != nullptr ? reason : k_file});
}

template <class Function>
void find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(::dlsym(library, name));
  if (function == nullptr) refuse();
}

ServerLibrary load() {
  void* const library = ::dlopen(k_file, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) refuse();
  ServerLibrary all;
  find(library, "PQconnectdbParams", all.connect);
  find(library, "PQfinish", all.finish);
  find(library, "PQstatus", all.status);
  find(library, "PQerrorMessage", all.error_message);
  find(library, "PQsetNoticeProcessor", all.set_notice_processor);
  find(library, "PQtransactionStatus", all.transaction_status);
  find(library, "PQsocket", all.socket);
  find(library, "PQsendQueryParams", all.send_query);
  find(library, "PQsetnonblocking", all.set_nonblocking);
  find(library, "PQflush", all.flush);
  find(library, "PQconsumeInput", all.consume_input);
  find(library, "PQisBusy", all.is_busy);
  find(library, "PQgetResult", all.get_result);
  find(library, "PQresultStatus", all.result_status);
  find(library, "PQresultErrorField", all.result_error_field);
  find(library, "PQclear", all.clear);
  find(library, "PQntuples", all.row_count);
  find(library, "PQgetisnull", all.is_null);
  find(library, "PQgetlength", all.length);
  find(library, "PQgetvalue", all.value);
  find(library, "PQgetCopyData", all.get_copy_data);
  find(library, "PQputCopyData", all.put_copy_data);
  find(library, "PQputCopyEnd", all.put_copy_end);
  find(library, "PQfreemem", all.free_memory);
  find(library, "PQgetCancel", all.get_cancel);
  find(library, "PQcancel", all.cancel);
  find(library, "PQfreeCancel", all.free_cancel);
  return all;
}

}  // namespace

const ServerLibrary& server_library() {
  static const ServerLibrary library = load();
  return library;
}

}  // namespace alidade
