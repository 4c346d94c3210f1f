#pragma once
#include "batten/session/json_detail.hpp"
#include "batten/session/request.hpp"

// Private to the room: requests in journals.
namespace batten::detail {

/// {"kind": …, option: value, …}, every option written.
Json json_of(const Request& request);
/// Options that are not there have their defaults. @throws InvalidInput naming the option.
Request request_of(const Json& json);

}  // namespace batten::detail
