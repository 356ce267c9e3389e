#include "tools/charts/run_page.h"

#include <utility>

#include "datapath/composition.h"
#include "formats/depth_format.h"
#include "report/counters.h"
#include "scenario/names.h"
#include "tools/charts/base64.h"
#include "tools/charts/embedded_files.h"
#include "tools/charts/page_template.h"

namespace metabuffer::charts {
namespace {

template <typename Owner>
Json counters_json() {
    Json list = Json::array();
    for (const Counter<Owner>& counter : Counters<Owner>::kTable) {
        list.push_back({{"name", counter.name}, {"unit", counter.unit}, {"meaning", counter.meaning}});
    }
    return list;
}

/// The tables of R, G and B by the display's index.
Json corrections_json(const DisplayConfig& displays) {
    Json tables = Json::object();
    for (const DisplayCorrection& correction : displays.correction) {
        tables[std::to_string(correction.display - 1)] = correction.table().channels();
    }
    return tables;
}

Json machine_json(const Scenario& scenario) {
    const DisplayConfig& displays = scenario.displays;
    Json renderers = Json::array();
    for (const Renderer& renderer : scenario.renderers) {
        renderers.push_back({{"name", renderer.name},
                             {"width", renderer.image_width_pixels},
                             {"height", renderer.image_height_pixels}});
    }
    return {{"columns", displays.columns},
            {"rows", displays.rows},
            {"width", displays.width_pixels},
            {"height", displays.height_pixels},
            {"supersample", displays.supersample},
            {"background", displays.background},
            {"corrections", corrections_json(displays)},
            {"composition", to_string(scenario.composition)},
            {"smoothing", to_string(scenario.composer.smoothing)},
            {"depth",
             {{"alpha_shift", layout_of(scenario.depth_format).alpha_shift},
              {"alpha_bits", layout_of(scenario.depth_format).alpha_bits},
              {"z_shift", layout_of(scenario.depth_format).z_shift},
              {"z_bits", layout_of(scenario.depth_format).z_bits}}},
            {"core_mhz", scenario.clocks.core_mhz},
            {"period_ps", clock_period_picoseconds(scenario.clocks.core_mhz)},
            {"buffer_pixels", scenario.composer.buffer_pixels},
            {"ready_space_pixels", scenario.composer.ready_space_pixels},
            {"renderers", std::move(renderers)}};
}

/// Each picture is in its own element, so that the browser decodes only those that the page shows.
std::string picture_elements(const PagePictures& pictures) {
    std::string text;
    for (std::size_t n = 0; n < pictures.files().size(); ++n) {
        text += "<script type=\"application/base64\" id=\"picture-" + std::to_string(n) + "\">" +
                base64(*pictures.files()[n]) + "</script>\n";
    }
    return text;
}

}  // namespace

std::string run_page(const RunPage& page) {
    PagePictures pictures;
    Json data;
    data["title"] = page.title;
    data["command"] = page.command;
    data["remarks"] = page.remarks;
    data["advice"] = page.advice;
    data["machine"] = machine_json(page.scenario);
    data["safe_buffer_pixels"] = page.safe_buffer_pixels ? Json(*page.safe_buffer_pixels) : Json();
    data["frames"] = page.pictures.json(pictures);
    data["stride"] = page.pictures.stride();
    Contributions contributions(page.scenario, page.most_image_bytes);
    for (Json& shown : data["frames"]) {
        const auto frame = shown["frame"].get<std::size_t>();
        if (frame < page.report.frames.size()) {
            shown["contributions"] = contributions.frame_json(page.report.frames[frame].pairs, pictures);
        }
    }
    data["images"] = contributions.images_json();
    data["tables"] = contributions.tables_json();
    data["images_left_out"] = contributions.images_left_out();
    data["record"] = page.record.json();
    data["counters"] = {{"buses", counters_json<BusCounters>()},
                        {"renderers", counters_json<RendererCounters>()},
                        {"composers", counters_json<ComposerCounters>()},
                        {"displays", counters_json<DisplayCounters>()}};
    data["summary"] = report_summary(page.report);
    data["report"] = Json::parse(page.report_json);

    const std::string title = html_text(page.title);
    const std::string style =
        std::string(embedded_file("page.css")) + std::string(embedded_file("run_page.css"));
    const std::string data_text = script_text(data);
    const std::string picture_text = picture_elements(pictures);
    return filled(embedded_file("run_page.html"), {{"TITLE", title},
                                                   {"STYLE", style},
                                                   {"DATA", data_text},
                                                   {"PICTURES", picture_text},
                                                   {"ELEMENTS", embedded_file("elements.js")},
                                                   {"RUN_DATA", embedded_file("run_data.js")},
                                                   {"RUN_WALL", embedded_file("run_wall.js")},
                                                   {"RUN_TIME", embedded_file("run_time.js")},
                                                   {"RUN_PAGE", embedded_file("run_page.js")}});
}

}  // namespace metabuffer::charts
