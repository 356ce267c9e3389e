#include "tools/charts/base64.h"

#include <cstddef>
#include <cstdint>

namespace metabuffer::charts {

std::string base64(std::string_view bytes) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    constexpr std::size_t kBytesAtOnce = 3;
    std::string text;
    text.reserve((bytes.size() + 2) / kBytesAtOnce * 4);
    for (std::size_t at = 0; at < bytes.size(); at += kBytesAtOnce) {
        const std::string_view part = bytes.substr(at, kBytesAtOnce);
        std::uint32_t bits = 0;
        for (std::size_t n = 0; n < kBytesAtOnce; ++n) {
            bits = bits << 8U | (n < part.size() ? static_cast<unsigned char>(part[n]) : 0U);
        }
        for (std::size_t digit = 0; digit < 4; ++digit) {
            const bool is_padding = digit > part.size();
            text += is_padding ? '=' : kDigits[bits >> (18U - 6U * digit) & 63U];
        }
    }
    return text;
}

}  // namespace metabuffer::charts
