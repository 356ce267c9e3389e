#pragma once

#include <string>
#include <string_view>

namespace metabuffer::charts {

/// Bytes as text, as data URLs have them (RFC 4648, padded).
std::string base64(std::string_view bytes);

}  // namespace metabuffer::charts
