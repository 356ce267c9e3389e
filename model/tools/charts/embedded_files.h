#pragma once

#include <string_view>

/// The files of this folder that are part of the program, as they are.
namespace metabuffer::charts::embedded {

/// Vega, as one script that defines a constant `vega`.
std::string_view vega_bundle();
/// Turns rows of results into Vega's specifications: `metabufferCharts`.
std::string_view charts_js();
/// What the pages have in common: `metabufferElements`.
std::string_view elements_js();
std::string_view page_js();
std::string_view page_css();
/// Has @NAME@ where the page's parts go.
std::string_view page_html();
/// The page about one run: its data (`metabufferRun`), the displays, the time line, and the script that connects them.
std::string_view run_data_js();
std::string_view run_wall_js();
std::string_view run_time_js();
std::string_view run_page_js();
/// Follows page_css() in the page about one run.
std::string_view run_page_css();
std::string_view run_page_html();
/// `metabufferPlot`, for node.
std::string_view plot_js();

}  // namespace metabuffer::charts::embedded
