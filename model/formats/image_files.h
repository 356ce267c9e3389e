#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

namespace metabuffer {

/// Where a renderer's image comes from: its file, and its Z if that is not in it.
struct ImageFiles {
    std::filesystem::path image;
    std::optional<std::filesystem::path> depth = std::nullopt;  ///< a file of Z
    std::optional<double> z = std::nullopt;                     ///< one depth for all of it, in its range
    std::optional<std::string> layer = std::nullopt;            ///< of the colours, if the file has several
    std::optional<std::string> depth_layer = std::nullopt;      ///< of Z, in its file
    std::optional<std::pair<double, double>> depth_range =
        std::nullopt;  ///< near and far, if they are its own

  private:
    auto all() const { return std::tie(image, depth, z, layer, depth_layer, depth_range); }

  public:
    friend bool operator<(const ImageFiles& a, const ImageFiles& b) { return a.all() < b.all(); }
};

}  // namespace metabuffer
