#pragma once

#include <map>
#include <string>
#include <string_view>

/// What pages for a browser are put together from.
namespace metabuffer::charts {

/// Text for the inside of an element or an attribute.
std::string html_text(const std::string& text);

/// The template with each @NAME@ replaced. What is put in is not looked at again.
std::string filled(std::string_view page, const std::map<std::string, std::string_view>& parts);

/// Bytes in zlib's format, which browsers unpack as "deflate". Throws std::runtime_error.
std::string deflated(std::string_view bytes);

}  // namespace metabuffer::charts
