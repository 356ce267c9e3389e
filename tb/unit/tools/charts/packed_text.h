#pragma once

#include <zlib.h>

#include <catch2/catch.hpp>
#include <cstddef>
#include <string>

// Unpacks long lists as a page's script does. It shares no code with the packing.
namespace metabuffer::test {

inline std::string from_base64(const std::string& text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0;
    int held = 0;
    for (const char character : text) {
        if (character == '=') break;
        bits = bits << 6U | static_cast<unsigned>(digits.find(character));
        held += 6;
        if (held >= 8) {
            held -= 8;
            bytes += static_cast<char>(bits >> static_cast<unsigned>(held) & 0xFFU);
        }
    }
    return bytes;
}

/// The result has one MiB at most.
inline std::string inflated(const std::string& bytes) {
    std::string text(std::size_t{1} << 20U, '\0');
    uLongf size = text.size();
    REQUIRE(uncompress(reinterpret_cast<Bytef*>(text.data()), &size,
                       reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()) == Z_OK);
    text.resize(size);
    return text;
}

}  // namespace metabuffer::test
