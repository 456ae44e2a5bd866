// SPDX-License-Identifier: MIT
#include "extensions/postgres/server_connection.h"

#include <libpq-fe.h>
#include <poll.h>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/error.h"
#include "base/shared_library.h"

namespace alidade::database {

namespace {

/// PostgreSQL's client library, which is loaded at the first use of a server. Errors: it is missing.
class ServerLibrary {
  template <class Function>
  Function find(const char* name) const {
    return reinterpret_cast<Function>(library_.find(name));
  }

  // The version of the interface, which has been the same since PostgreSQL 8.2.
  SharedLibrary library_{"libpq.so.5", "server connections require the PostgreSQL client library",
                         "the package libpq5 or an equivalent"};

 public:
#define ALIDADE_FROM_LIBPQ(name, function) decltype(&::function) name = find<decltype(&::function)>(#function)
  ALIDADE_FROM_LIBPQ(connect, PQconnectdbParams);
  ALIDADE_FROM_LIBPQ(finish, PQfinish);
  ALIDADE_FROM_LIBPQ(status, PQstatus);
  ALIDADE_FROM_LIBPQ(error_message, PQerrorMessage);
  ALIDADE_FROM_LIBPQ(set_notice_processor, PQsetNoticeProcessor);
  ALIDADE_FROM_LIBPQ(transaction_status, PQtransactionStatus);
  ALIDADE_FROM_LIBPQ(socket, PQsocket);
  ALIDADE_FROM_LIBPQ(send_query, PQsendQueryParams);
  ALIDADE_FROM_LIBPQ(set_nonblocking, PQsetnonblocking);
  ALIDADE_FROM_LIBPQ(flush, PQflush);
  ALIDADE_FROM_LIBPQ(consume_input, PQconsumeInput);
  ALIDADE_FROM_LIBPQ(is_busy, PQisBusy);
  ALIDADE_FROM_LIBPQ(get_result, PQgetResult);
  ALIDADE_FROM_LIBPQ(result_status, PQresultStatus);
  ALIDADE_FROM_LIBPQ(result_error_field, PQresultErrorField);
  ALIDADE_FROM_LIBPQ(clear, PQclear);
  ALIDADE_FROM_LIBPQ(row_count, PQntuples);
  ALIDADE_FROM_LIBPQ(is_null, PQgetisnull);
  ALIDADE_FROM_LIBPQ(length, PQgetlength);
  ALIDADE_FROM_LIBPQ(value, PQgetvalue);
  ALIDADE_FROM_LIBPQ(get_copy_data, PQgetCopyData);
  ALIDADE_FROM_LIBPQ(put_copy_data, PQputCopyData);
  ALIDADE_FROM_LIBPQ(put_copy_end, PQputCopyEnd);
  ALIDADE_FROM_LIBPQ(free_memory, PQfreemem);
  ALIDADE_FROM_LIBPQ(get_cancel, PQgetCancel);
  ALIDADE_FROM_LIBPQ(cancel, PQcancel);
  ALIDADE_FROM_LIBPQ(free_cancel, PQfreeCancel);
#undef ALIDADE_FROM_LIBPQ
};

/// Thread safe.
const ServerLibrary& server_library() {
  static const ServerLibrary library;
  return library;
}

/// A text as one line, without blanks at its ends.
std::string one_line(const char* text) {
  std::string line;
  for (const char character : std::string_view(text == nullptr ? "" : text)) {
    const bool is_blank = static_cast<unsigned char>(character) <= ' ';
    if (!is_blank)
      line += character;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  while (line.ends_with(' ')) line.pop_back();
  return line;
}

/// The server's message about a statement that failed.
std::string message_of(const PGresult* result) {
  const ServerLibrary& library = server_library();
  std::string text = one_line(library.result_error_field(result, PG_DIAG_MESSAGE_PRIMARY));
  const std::string detail = one_line(library.result_error_field(result, PG_DIAG_MESSAGE_DETAIL));
  return detail.empty() ? text : text + "; " + detail;
}

/// The number of a text; 0 for text without a number.
template <class Number>
Number number_in(const std::string& text) {
  Number value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
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
  const int row_number = static_cast<int>(row);
  return std::string(server_library().value(result_, row_number, column),
                     static_cast<std::size_t>(server_library().length(result_, row_number, column)));
}

double ServerRows::number(std::size_t row, int column) const {
  return number_in<double>(text(row, column));
}

std::int64_t ServerRows::whole(std::size_t row, int column) const {
  return number_in<std::int64_t>(text(row, column));
}

ServerConnection::ServerConnection(const ServerName& name) : name_(name.shown()) {
  const ServerLibrary& library = server_library();
  std::vector<const char*> keywords = {"connect_timeout", "fallback_application_name"};
  std::vector<const char*> values = {"10", "alidade"};
  for (const auto& [keyword, value] : name.parameters) {
    keywords.push_back(keyword.c_str());
    values.push_back(value.c_str());
  }
  // All texts are UTF-8, also if the name has another encoding.
  keywords.push_back("client_encoding");
  values.push_back("UTF8");
  keywords.push_back(nullptr);
  values.push_back(nullptr);
  constexpr int k_expand_nothing = 0;
  connection_ = library.connect(keywords.data(), values.data(), k_expand_nothing);
  if (connection_ == nullptr) throw std::bad_alloc();
  if (library.status(connection_) != CONNECTION_OK) {
    const std::string reason = one_line(library.error_message(connection_));
    library.finish(connection_);
    fail("cannot connect to the server: " + reason);
  }
  library.set_notice_processor(connection_, ignore_notice, nullptr);
  if (library.set_nonblocking(connection_, 1) != 0) {
    library.finish(connection_);
    fail("unusable connection to the server");
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
                            std::string location) const {
  throw Error(name_, std::move(location), std::move(problem), std::move(expected), std::move(found));
}

void ServerConnection::fail_with_reason(const char* problem) const {
  const std::string reason = one_line(server_library().error_message(connection_));
  fail(reason.empty() ? std::string(problem) : problem + (": " + reason));
}

void ServerConnection::wait_for_socket(bool to_write, const ServerWait& wait) {
  constexpr int k_milliseconds = 100;
  pollfd socket{server_library().socket(connection_),
                static_cast<short>(to_write ? POLLIN | POLLOUT : POLLIN), 0};
  ::poll(&socket, 1, k_milliseconds);
  if (wait) wait();
  if (server_library().consume_input(connection_) == 0) fail_as_lost();
}

void ServerConnection::flush(const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  for (int left = library.flush(connection_); left != 0; left = library.flush(connection_)) {
    if (left < 0) fail_as_lost();
    wait_for_socket(true, wait);
  }
}

void ServerConnection::wait_while_busy(const ServerWait& wait) {
  flush(wait);
  while (server_library().is_busy(connection_) != 0) wait_for_socket(false, wait);
}

void ServerConnection::send(const std::string& sql, std::span<const std::string> values) {
  std::vector<const char*> texts;
  for (const std::string& value : values) texts.push_back(value.c_str());
  constexpr int k_as_text = 0;
  if (server_library().send_query(connection_, sql.c_str(), static_cast<int>(texts.size()), nullptr,
                                  texts.data(), nullptr, nullptr, k_as_text) == 0)
    fail_as_lost();
}

ServerRows ServerConnection::result(int wanted, const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  wait_while_busy(wait);
  PGresult* const answer = library.get_result(connection_);
  if (answer == nullptr) fail_with_reason("the server does not respond");
  ServerRows rows(answer);
  const ExecStatusType status = library.result_status(answer);
  if (status == wanted || (wanted == PGRES_TUPLES_OK && status == PGRES_COMMAND_OK)) return rows;
  const std::string message = message_of(answer);
  if (message.empty()) fail_with_reason("unexpected response of the server");
  fail("the server reports an error: " + message);
}

/// Reads the end of a statement after its result. Errors: the statement failed after all.
void ServerConnection::finish_statement(const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  for (wait_while_busy(wait); PGresult* const answer = library.get_result(connection_);
       wait_while_busy(wait)) {
    const ServerRows rows(answer);
    const ExecStatusType status = library.result_status(answer);
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK)
      fail("the server reports an error: " + message_of(answer));
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
    if (count < 0) fail_as_lost();
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
    if (done < 0) fail_as_lost();
    if (done == 0)
      wait_for_socket(true, wait);
    else
      bytes = bytes.subspan(count);
  }
  // Otherwise libpq would keep in memory what the server does not accept at once.
  flush(wait);
}

void ServerConnection::end_copy_in(const ServerWait& wait) {
  const ServerLibrary& library = server_library();
  int done = 0;
  while ((done = library.put_copy_end(connection_, nullptr)) == 0) wait_for_socket(true, wait);
  if (done < 0) fail_as_lost();
  finish_statement(wait);
}

}  // namespace alidade::database
