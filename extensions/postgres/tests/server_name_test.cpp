// SPDX-License-Identifier: MIT
// How tables of servers are named, and what messages repeat of that.
#include "extensions/postgres/server_name.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace alidade::test {

using namespace database;

namespace {

std::string error_of(const std::string& name) {
  try {
    const ServerName parsed(name);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(ServerName, parts_are_separated) {
  const ServerName name("postgresql://anna@db1:5433/survey?table=site&schema=a%20b&sslmode=require");
  EXPECT_EQ(name.parameter("user"), "anna");
  EXPECT_EQ(name.parameter("host"), "db1");
  EXPECT_EQ(name.parameter("port"), "5433");
  EXPECT_EQ(name.parameter("dbname"), "survey");
  EXPECT_EQ(name.parameter("sslmode"), "require");
  EXPECT_EQ(name.table, "site");
  EXPECT_EQ(name.schema, "a b");
  EXPECT_EQ(name.shown(), "postgresql://db1:5433/survey?table=site");
}

TEST(ServerName, parts_may_be_left_out_or_encoded) {
  EXPECT_TRUE(ServerName("postgresql://").parameters.empty());
  EXPECT_EQ(ServerName("postgres:///survey").parameter("dbname"), "survey");
  EXPECT_EQ(ServerName("postgresql://[::1]:5433/d?table=t").parameter("host"), "::1");
  EXPECT_EQ(ServerName("postgresql://[::1]:5433/d?table=t").shown(), "postgresql://[::1]:5433/d?table=t");
  const ServerName socket("postgresql://%2Frun%2Fpg/d?table=a%26b%3D%22%25&port=5434");
  EXPECT_EQ(socket.parameter("host"), "/run/pg");
  EXPECT_EQ(socket.parameter("port"), "5434");
  EXPECT_EQ(socket.table, "a&b=\"%");
  EXPECT_EQ(ServerName("postgresql://h/d?host=/run/pg&table=t").parameter("host"), "/run/pg");
  // What is shown names the same table again.
  EXPECT_EQ(ServerName(socket.shown()).table, socket.table);
  EXPECT_EQ(ServerName("postgresql://h/d?table=a\nb").shown(), "postgresql://h/d?table=a%0Ab");
}

TEST(ServerName, passwords_are_rejected_and_not_repeated) {
  for (const char* const name :
       {"postgresql://me:geheim@h/d?table=t", "postgresql://me%3Ageheim@h/d?table=t",
        "postgresql://me:ge@heim@h/d", "postgresql://me:ge/heim@h/d",
        "postgresql://h/d?password=geheim&table=t", "postgresql://h/d?table=t&p%61ssword=geheim",
        "postgresql://h/d?table=t&sslpassword=geheim", "postgresql://h/d?table=t&PassWord=geheim",
        "postgresql://h/d?oauth_client_secret=geheim"}) {
    const std::string error = error_of(name);
    EXPECT_NE(error.find("PGPASSWORD"), std::string::npos) << name << ": " << error;
    EXPECT_EQ(error.find("heim"), std::string::npos) << error;
  }
  // Passwords with marks in them, which make something else of the name.
  for (const char* const name : {"postgresql://me:ge?heim@h/d", "postgresql://me:12?heim@h/d?table=t"}) {
    const std::string error = error_of(name);
    EXPECT_NE(error, "") << name;
    EXPECT_EQ(error.find("heim"), std::string::npos) << error;
  }
}

TEST(ServerName, invalid_names_are_errors) {
  for (const char* const name :
       {"postgresql://h:0/d", "postgresql://h:65536/d", "postgresql://h:x/d", "postgresql://[::1/d",
        "postgresql://[::1]x/d", "postgresql://h/d?table=%", "postgresql://h/d?table=%4",
        "postgresql://h/d?table=%zz", "postgresql://h/d?table=%00", "postgresql://h/d?=t",
        "postgresql://h/d?ta ble=t"})
    EXPECT_NE(error_of(name), "") << name;
  EXPECT_TRUE(is_server_name("postgres://"));
  EXPECT_FALSE(is_server_name("postgres.db?table=points"));
}

}  // namespace
}  // namespace alidade::test
