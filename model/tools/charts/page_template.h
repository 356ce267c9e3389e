#pragma once

#include <map>
#include <string>
#include <string_view>

/// Functions that assemble pages for a browser.
namespace metabuffer::charts {

/// Text that is safe inside an element or an attribute.
std::string html_text(const std::string& text);

/// The template with each @NAME@ replaced. A @NAME@ in the text that is put in stays as it is.
std::string filled(std::string_view page, const std::map<std::string, std::string_view>& parts);

/// Bytes in zlib's format, which browsers unpack as "deflate". Throws std::runtime_error.
std::string deflated(std::string_view bytes);

}  // namespace metabuffer::charts
