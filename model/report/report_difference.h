#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"

namespace metabuffer {

/// The names of the two compared runs in the lines, for example their levels.
struct ComparedNames {
    std::string left = "rtl";
    std::string right = "tlm";
};

struct ReportComparison {
    /// One line each: the key path with names, then both values:
    /// "composers[renderer ball, display 3].starved_pixels: rtl 12, tlm 13".
    std::vector<std::string> differences;
    /// Numbers, texts and nulls compared; a value that only one report has counts, too.
    std::size_t values = 0;
};

/// Compares two reports, texts as report_json() makes them, value by value; the key `level` may differ. Of a list of
/// texts (starved runs, the watchdog's lines) only the first that differs is reported, with the number of those that
/// differ, since one text too many shifts all after it. Throws std::invalid_argument if a text is not a JSON object.
ReportComparison compare_reports(const std::string& left, const std::string& right,
                                 const ComparedNames& names = {});

/// One line on how two pictures of a display (from 1) and frame (from 0) differ, nothing if they do not; null
/// stands for a picture that a run did not show.
/// "display_2 frame 0: 17 pixels differ, first at 12,5: rtl #102030, tlm #102031".
std::optional<std::string> picture_difference(int display, int frame, const ColourImage* left,
                                              const ColourImage* right, const ComparedNames& names = {});

}  // namespace metabuffer
