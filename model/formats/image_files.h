#pragma once

#include <filesystem>
#include <optional>
#include <tuple>

namespace metabuffer {

/// Where a renderer's image comes from: its file, and its Z if that is not a channel of it.
struct ImageFiles {
    std::filesystem::path image;
    std::optional<std::filesystem::path> depth = std::nullopt;  ///< a file of Z
    std::optional<double> z = std::nullopt;                     ///< one depth for all of it, in depth_range

    friend bool operator<(const ImageFiles& a, const ImageFiles& b) {
        return std::tie(a.image, a.depth, a.z) < std::tie(b.image, b.depth, b.z);
    }
};

}  // namespace metabuffer
