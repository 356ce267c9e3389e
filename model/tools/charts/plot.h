#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace metabuffer::charts {

enum class ChartKind { kLines, kHeatmap, kPareto, kPolicy, kHistogram, kScatter };
/// "lines", "heatmap", "pareto", "policy", "histogram", "scatter".
const std::vector<std::string>& chart_names();
ChartKind chart_of(const std::string& name);

/// A line across the chart at a value of its figure.
struct ReferenceLine {
    double value = 0.0;
    std::string label;
};

/// What to draw. Expressions are over the results' columns; the results' axes decide what replaces an empty one.
struct PlotRequest {
    ChartKind chart = ChartKind::kLines;
    std::string x;
    std::vector<std::string> y;
    std::string colour;
    std::string facet;      ///< a panel for each of its values
    std::string label;      ///< names of points on a front
    std::string condition;  ///< empty: all points
    std::string title;
    std::string x_title;  ///< empty: what the expression is called
    std::string y_title;
    std::string colour_title;
    std::string facet_title;
    bool log_x = false;  ///< false: only if the values grow by a factor, as 32, 64, 128 do
    bool log_y = false;
    int width_pixels = 720;
    int height_pixels = 440;
    std::vector<ReferenceLine> references;
};

/// The chart as SVG, drawn by node, of files of one sweep. Throws InputError for what cannot be drawn, OutputError
/// without node.
std::string plot_svg(const std::vector<std::filesystem::path>& results, const PlotRequest& request);

/// SVG as PNG of twice its size, by rsvg-convert. Throws OutputError without it.
std::string png_of(const std::string& svg);

}  // namespace metabuffer::charts
