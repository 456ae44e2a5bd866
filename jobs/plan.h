// SPDX-License-Identifier: MIT
#pragma once

#include <utility>

namespace alidade::jobs {

/// A checked request. Only the plan() of the request makes one: what is made otherwise was not checked.
template <class Request>
class Plan {
 public:
  explicit Plan(Request request) : request_(std::move(request)) {}

  const Request& request() const { return request_; }

 private:
  Request request_;
};

}  // namespace alidade::jobs
