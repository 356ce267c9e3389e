#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/report.h"
#include "scenario/scenario.h"
#include "tools/charts/run_pictures.h"
#include "tools/charts/run_record.h"

namespace metabuffer::charts {

/// What a page about one run is made of.
struct RunPage {
    const Scenario& scenario;
    const RunReport& report;
    const std::string& report_json;  ///< the same, as its file
    const RunRecord& record;
    const ShownPictures& pictures;
    std::string title = {};
    std::vector<std::string> command = {};  ///< the words that run it by hand, up to its options
    std::vector<std::string> remarks = {};  ///< lines for the reader
    /// With so many pixels of buffer nothing starves, by proof; none if nothing is proved.
    std::optional<std::int64_t> safe_buffer_pixels = std::nullopt;
    std::size_t most_image_bytes = 0;  ///< of the renderers' images
};

/// One HTML file with all that it shows inside: displays frame by frame, who won each pixel and why, and what links,
/// buses, buffers and displays did when. Throws OutputError.
std::string run_page(const RunPage& page);

}  // namespace metabuffer::charts
