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
    const std::string& report_json;  ///< the same report, as the text of its file
    const RunRecord& record;
    const ShownPictures& pictures;
    std::string title = {};
    std::vector<std::string> command =
        {};  ///< words of the command that repeats the run; the page adds options
    std::vector<std::string> remarks = {};  ///< lines for the reader
    std::vector<std::string> advice = {};   ///< changes of the scenario that keep pixels from starving
    /// A size of the buffers with which no pixel starves, by proof; nullopt if nothing is proved.
    std::optional<std::int64_t> safe_buffer_pixels = std::nullopt;
    std::size_t most_image_bytes = 0;  ///< for the renderers' images
};

/// One HTML file that contains all it shows: the displays frame by frame, which renderer won each pixel and why, and
/// what links, buses, buffers and displays did when. Throws OutputError.
std::string run_page(const RunPage& page);

}  // namespace metabuffer::charts
