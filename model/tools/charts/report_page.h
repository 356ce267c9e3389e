#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace metabuffer::charts {

constexpr std::size_t kBytesPerMebibyte = std::size_t{1} << 20;

struct PageOptions {
    std::string title;      ///< empty: the results' names
    std::string condition;  ///< an expression over the results' columns; empty: all points
    /// The most bytes of reports and pictures in the page. The page leaves out those beyond, and says so.
    std::size_t most_embedded_bytes = 24 * kBytesPerMebibyte;
};

/// The most points of a page: no browser opens a page with more.
constexpr std::int64_t kMostPagePoints = 200'000;

/// Results as one page of HTML that needs nothing but a browser: charts, table, and each point's report and pictures.
/// The same results give the same bytes. Throws InputError for files that are no results, for a bad condition and for
/// too many points.
std::string report_page(const std::vector<std::filesystem::path>& files, const PageOptions& options);

}  // namespace metabuffer::charts
