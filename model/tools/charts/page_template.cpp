#include "tools/charts/page_template.h"

#include <zlib.h>

#include <stdexcept>

namespace metabuffer::charts {

std::string html_text(const std::string& text) {
    std::string result;
    for (const char character : text) {
        switch (character) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '"':
                result += "&quot;";
                break;
            default:
                result += character;
        }
    }
    return result;
}

std::string filled(std::string_view page, const std::map<std::string, std::string_view>& parts) {
    std::string result;
    std::size_t at = 0;
    while (true) {
        const std::size_t begin = page.find('@', at);
        if (begin == std::string_view::npos) break;
        const std::size_t end = page.find('@', begin + 1);
        const auto part = end == std::string_view::npos
                              ? parts.end()
                              : parts.find(std::string(page.substr(begin + 1, end - begin - 1)));
        result += page.substr(at, begin - at);
        if (part == parts.end()) {
            result += '@';
            at = begin + 1;
        } else {
            result += part->second;
            at = end + 1;
        }
    }
    return result + std::string(page.substr(at));
}

std::string deflated(std::string_view bytes) {
    uLongf size = compressBound(bytes.size());
    std::string result(size, '\0');
    const int status =
        compress2(reinterpret_cast<Bytef*>(result.data()), &size,
                  reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), Z_DEFAULT_COMPRESSION);
    if (status != Z_OK) throw std::runtime_error("zlib cannot deflate a part of a page");
    result.resize(size);
    return result;
}

}  // namespace metabuffer::charts
