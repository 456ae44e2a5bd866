// SPDX-License-Identifier: MIT
#include "database/server/server_connection.h"

#include <dlfcn.h>
#include <libpq-fe.h>
#include <poll.h>
#include <algorithm>
#include <charconv>
#include <cstdint>

#include "base/error.h"

namespace alidade::database {

/// PostgreSQL's client library, which is loaded when a server is first asked: with what it brings along,
/// that takes longer than the work of many commands.
struct ServerLibrary {
  decltype(&::PQconnectdbParams) connect = nullptr;
  decltype(&::PQfinish) finish = nullptr;
  decltype(&::PQstatus) status = nullptr;
  decltype(&::PQerrorMessage) error_message = nullptr;
  decltype(&::PQsetNoticeProcessor) set_notice_processor = nullptr;
  decltype(&::PQtransactionStatus) transaction_status = nullptr;
  decltype(&::PQsocket) socket = nullptr;
  decltype(&::PQsendQueryParams) send_query = nullptr;
  decltype(&::PQsetnonblocking) set_nonblocking = nullptr;
  decltype(&::PQflush) flush = nullptr;
  decltype(&::PQconsumeInput) consume_input = nullptr;
  decltype(&::PQisBusy) is_busy = nullptr;
  decltype(&::PQgetResult) get_result = nullptr;
  decltype(&::PQresultStatus) result_status = nullptr;
  decltype(&::PQresultErrorField) result_error_field = nullptr;
  decltype(&::PQclear) clear = nullptr;
  decltype(&::PQntuples) row_count = nullptr;
  decltype(&::PQgetisnull) is_null = nullptr;
  decltype(&::PQgetlength) length = nullptr;
  decltype(&::PQgetvalue) value = nullptr;
  decltype(&::PQgetCopyData) get_copy_data = nullptr;
  decltype(&::PQputCopyData) put_copy_data = nullptr;
  decltype(&::PQputCopyEnd) put_copy_end = nullptr;
  decltype(&::PQfreemem) free_memory = nullptr;
  decltype(&::PQgetCancel) get_cancel = nullptr;
  decltype(&::PQcancel) cancel = nullptr;
  decltype(&::PQfreeCancel) free_cancel = nullptr;
};

/// Stays loaded. Errors: the library is not there. Thread safe.
const ServerLibrary& server_library();

namespace {

/// The version of the interface, which has been the same since PostgreSQL 8.2.
constexpr const char* k_file = "libpq.so.5";

[[noreturn]] void refuse_library() {
  const char* const reason = ::dlerror();
  throw Error({.problem = "servers cannot be asked without PostgreSQL's client library",
               .expected = "Debian's package libpq5, or its like",
               .found = reason != nullptr ? reason : k_file});
}

template <class Function>
void find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(::dlsym(library, name));
  if (function == nullptr) refuse_library();
}

ServerLibrary load() {
  void* const library = ::dlopen(k_file, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) refuse_library();
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

namespace {

/// One line, without what stands around it.
std::string one_line(const char* text) {
  std::string line;
  for (const char letter : std::string_view(text == nullptr ? "" : text)) {
    const bool is_blank = static_cast<unsigned char>(letter) <= ' ';
    if (!is_blank)
      line += letter;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  while (line.ends_with(' ')) line.pop_back();
  return line;
}

/// The server's words about a statement that failed.
std::string words_of(const PGresult* result) {
  const ServerLibrary& library = server_library();
  std::string text = one_line(library.result_error_field(result, PG_DIAG_MESSAGE_PRIMARY));
  const std::string detail = one_line(library.result_error_field(result, PG_DIAG_MESSAGE_DETAIL));
  return detail.empty() ? text : text + "; " + detail;
}

void ignore_notice(void*, const char*) {}

}  // namespace

ServerRows::~ServerRows() {
  if (result_ != nullptr) server_library().clear(result_);
}

std::size_t ServerRows::size() const {
  return static_cast<std::size_t>(server_library().row_count(result_));
}

bool ServerRows::is_null(std::size_t row, int column) const {
  return server_library().is_null(result_, static_cast<int>(row), column) != 0;
}

std::string ServerRows::text(std::size_t row, int column) const {
  const int place = static_cast<int>(row);
  return std::string(server_library().value(result_, place, column),
                     static_cast<std::size_t>(server_library().length(result_, place, column)));
}

double ServerRows::number(std::size_t row, int column) const {
  const std::string word = text(row, column);
  double value = 0.0;
  std::from_chars(word.data(), word.data() + word.size(), value);
  return value;
}

std::int64_t ServerRows::whole(std::size_t row, int column) const {
  const std::string word = text(row, column);
  std::int64_t value = 0;
  std::from_chars(word.data(), word.data() + word.size(), value);
  return value;
}

ServerConnection::ServerConnection(const ServerName& name) : name_(name.shown()) {
  const ServerLibrary& library = server_library();
  std::vector<const char*> words = {"connect_timeout", "fallback_application_name"};
  std::vector<const char*> values = {"10", "alidade"};
  for (const auto& [word, value] : name.parameters) {
    words.push_back(word.c_str());
    values.push_back(value.c_str());
  }
  // Whatever the name says: all texts are UTF-8.
  words.push_back("client_encoding");
  values.push_back("UTF8");
  words.push_back(nullptr);
  values.push_back(nullptr);
  constexpr int k_expand_nothing = 0;
  connection_ = library.connect(words.data(), values.data(), k_expand_nothing);
  if (connection_ == nullptr) throw std::bad_alloc();
  if (library.status(connection_) != CONNECTION_OK) {
    const std::string reason = one_line(library.error_message(connection_));
    library.finish(connection_);
    fail("the server cannot be asked", {}, reason);
  }
  library.set_notice_processor(connection_, ignore_notice, nullptr);
  if (library.set_nonblocking(connection_, 1) != 0) {
    library.finish(connection_);
    fail("the connection to the server cannot be used");
  }
}

ServerConnection::~ServerConnection() {
  const ServerLibrary& library = server_library();
  if (library.status(connection_) == CONNECTION_OK &&
      library.transaction_status(connection_) == PQTRANS_ACTIVE) {
    if (PGcancel* const cancel = library.get_cancel(connection_)) {
      char reason[256];
      library.cancel(cancel, reason, sizeof reason);
      library.free_cancel(cancel);
    }
  }
  library.finish(connection_);
}

void ServerConnection::fail(std::string problem, std::string expected, std::string found,
                            std::string place) const {
  throw Error({.file = name_,
               .place = std::move(place),
               .problem = std::move(problem),
               .expected = std::move(expected),
               .found = std::move(found)});
}

void ServerConnection::fail_as_told(const char* problem) const {
  fail(problem, {}, one_line(server_library().error_message(connection_)));
}

void ServerConnection::wait_for_socket(bool to_write, const ServerWait& wait) {
  constexpr int k_milliseconds = 100;
  pollfd socket{server_library().socket(connection_),
                static_cast<short>(to_write ? POLLIN | POLLOUT : POLLIN), 0};
  ::poll(&socket, 1, k_milliseconds);
  if (wait) wait();
  if (server_library().consume_input(connection_) == 0) fail_as_told("the connection to the server is lost");
}

void ServerConnection::wait_while_busy(const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  for (int left = library.flush(connection_); left != 0; left = library.flush(connection_)) {
    if (left < 0) fail_as_told("the connection to the server is lost");
    wait_for_socket(true, wait);
  }
  while (library.is_busy(connection_) != 0) wait_for_socket(false, wait);
}

void ServerConnection::send(const std::string& sql, std::span<const std::string> values) {
  std::vector<const char*> texts;
  for (const std::string& value : values) texts.push_back(value.c_str());
  constexpr int k_as_text = 0;
  if (server_library().send_query(connection_, sql.c_str(), static_cast<int>(texts.size()), nullptr,
                                  texts.data(), nullptr, nullptr, k_as_text) == 0)
    fail_as_told("the connection to the server is lost");
}

ServerRows ServerConnection::result(int wanted, const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  wait_while_busy(wait);
  PGresult* const answer = library.get_result(connection_);
  if (answer == nullptr) fail_as_told("the server does not answer");
  ServerRows rows(answer);
  const ExecStatusType status = library.result_status(answer);
  if (status == wanted || (wanted == PGRES_TUPLES_OK && status == PGRES_COMMAND_OK)) return rows;
  const std::string words = words_of(answer);
  if (words.empty()) fail_as_told("the server answers something else than it was asked");
  fail("the server refuses", {}, words);
}

/// Takes what stands behind a result: nothing, or that the statement failed after all.
void ServerConnection::finish_statement(const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  for (wait_while_busy(wait); PGresult* const answer = library.get_result(connection_);
       wait_while_busy(wait)) {
    const ServerRows rows(answer);
    const ExecStatusType status = library.result_status(answer);
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK)
      fail("the server refuses", {}, words_of(answer));
  }
}

ServerRows ServerConnection::run(const std::string& sql, std::span<const std::string> values,
                                 const ServerWait& wait) {
  send(sql, values);
  ServerRows rows = result(PGRES_TUPLES_OK, wait);
  finish_statement(wait);
  return rows;
}

void ServerConnection::copy_out(const std::string& sql,
                                const std::function<void(std::span<const std::byte>)>& take,
                                const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  constexpr int k_not_yet = 0, k_end = -1, k_do_not_wait = 1;
  send(sql, {});
  result(PGRES_COPY_OUT, wait);
  while (true) {
    char* bytes = nullptr;
    const int count = library.get_copy_data(connection_, &bytes, k_do_not_wait);
    if (count == k_end) break;
    if (count == k_not_yet) {
      wait_for_socket(false, wait);
      continue;
    }
    if (count < 0) fail_as_told("the connection to the server is lost");
    const std::unique_ptr<char, void (*)(char*)> owner(bytes,
                                                       [](char* all) { server_library().free_memory(all); });
    take(std::as_bytes(std::span(bytes, static_cast<std::size_t>(count))));
  }
  finish_statement(wait);
}

void ServerConnection::begin_copy_in(const std::string& sql) {
  send(sql, {});
  result(PGRES_COPY_IN, {});
}

void ServerConnection::put(std::span<const std::byte> bytes, const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  constexpr std::size_t k_most = 1 << 20;
  while (!bytes.empty()) {
    const std::size_t count = std::min(bytes.size(), k_most);
    const int done = library.put_copy_data(connection_, reinterpret_cast<const char*>(bytes.data()),
                                           static_cast<int>(count));
    if (done < 0) fail_as_told("the connection to the server is lost");
    if (done == 0)
      wait_for_socket(true, wait);
    else
      bytes = bytes.subspan(count);
  }
  // What the server does not take at once, libpq would keep in memory.
  for (int left = library.flush(connection_); left != 0; left = library.flush(connection_)) {
    if (left < 0) fail_as_told("the connection to the server is lost");
    wait_for_socket(true, wait);
  }
}

void ServerConnection::end_copy_in(const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  int done = 0;
  while ((done = library.put_copy_end(connection_, nullptr)) == 0) wait_for_socket(true, wait);
  if (done < 0) fail_as_told("the connection to the server is lost");
  finish_statement(wait);
}

}  // namespace alidade::database
