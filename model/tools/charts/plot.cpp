#include "tools/charts/plot.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "host/errors.h"
#include "host/filter_process.h"
#include "host/text.h"
#include "tools/charts/column_title.h"
#include "tools/charts/embedded_files.h"
#include "tools/charts/value_json.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/results_database.h"

namespace metabuffer::charts {

namespace {

using exploration::ResultsReader;
using exploration::Value;

constexpr const char* kArbitration = "bus.arbitration";
constexpr const char* kFrameRate = "frames_per_second";
constexpr const char* kFrameCycles = "frame_cycles";
constexpr const char* kStarved = "starved_pixels";
constexpr const char* kBufferBits = "buffer_bits";
constexpr const char* kSmallest = "smallest";

/// An axis of the results that has more than one value among the points drawn.
struct VariedAxis {
    std::string column;  ///< its name in expressions
    bool is_number = false;
    std::string twin;  ///< the first axis that varies together with it, or itself
};

/// Whether two columns of a table vary together: the value of each determines that of the other.
bool go_together(const ResultsReader::Table& table, std::size_t left, std::size_t right) {
    std::map<Value, Value> forth;
    std::map<Value, Value> back;
    return std::all_of(table.rows.begin(), table.rows.end(), [&](const std::vector<Value>& row) {
        return forth.emplace(row[left], row[right]).first->second == row[right] &&
               back.emplace(row[right], row[left]).first->second == row[left];
    });
}

std::vector<VariedAxis> varied_axes(const ResultsReader& reader, const std::string& condition) {
    const std::size_t count = reader.identity().keys.size();
    // The axes follow the point's number, some under other names than their keys.
    const auto first = reader.columns().begin() + 1;
    const std::vector<std::string> columns(first, first + static_cast<std::ptrdiff_t>(count));
    const ResultsReader::Table table = reader.results(condition);
    std::vector<VariedAxis> axes;
    for (std::size_t n = 0; n < count; ++n) {
        std::set<Value> values;
        for (const std::vector<Value>& row : table.rows) values.insert(row[n + 1]);
        if (values.size() < 2) continue;
        const bool is_number = std::none_of(values.begin(), values.end(), [](const Value& value) {
            return std::holds_alternative<std::string>(value);
        });
        VariedAxis axis{columns[n], is_number, columns[n]};
        for (std::size_t m = n; m > 0; --m) {
            if (go_together(table, n + 1, m)) axis.twin = columns[m - 1];
        }
        axes.push_back(std::move(axis));
    }
    return axes;
}

bool has_column(const ResultsReader& reader, const std::string& name) {
    const std::vector<std::string>& columns = reader.columns();
    return std::find(columns.begin(), columns.end(), name) != columns.end();
}

bool has_values(const ResultsReader& reader, const std::string& expression, const std::string& condition) {
    const ResultsReader::Table table = reader.results({expression}, condition);
    return std::any_of(table.rows.begin(), table.rows.end(),
                       [](const std::vector<Value>& row) { return row.front() != Value(); });
}

/// Fills in what a request leaves open, from the axes that vary in the results.
class Defaults {
  public:
    Defaults(const ResultsReader& reader, const PlotRequest& request)
        : is_search_(!reader.identity().search_key.empty()),
          cost_(has_column(reader, exploration::kCost) ? exploration::kCost : kBufferBits),
          has_rates_(has_values(reader, kFrameRate, request.condition)),
          axes_(varied_axes(reader, request.condition)) {}

    PlotRequest completed(PlotRequest request) const {
        switch (request.chart) {
            case ChartKind::kLines:
                complete(request.x, first_number());
                complete(request.y, {figure()});
                complete(request.colour, others({request.x, request.facet}));
                break;
            case ChartKind::kHeatmap:
                complete(request.x,
                         request.y.empty() ? first_number() : first_but({request.y.front(), request.facet}));
                complete(request.y, {first_but({request.x, request.facet})});
                complete(request.colour, is_search_ ? kSmallest : kStarved);
                break;
            case ChartKind::kPareto:
                complete(request.x, cost_);
                if (request.y.empty() && !has_rates_) {
                    throw InputError(
                        "--y: no point has a frame rate, for which a run needs three frames; name an "
                        "expression of which "
                        "more is better");
                }
                complete(request.y, {kFrameRate});
                complete(request.label, names());
                break;
            case ChartKind::kPolicy:
                complete(request.x, policy());
                complete(request.y, {"utilization", "recovered_slots"});
                break;
            case ChartKind::kHistogram:
                complete(request.x, figure());
                break;
            case ChartKind::kScatter:
                complete(request.x, cost_);
                complete(request.y, {rate()});
                complete(request.colour, first_text());
                break;
        }
        if (request.x.empty())
            throw InputError("--x: these results vary no axis to draw over; name an expression");
        if (!request.y.empty() && request.y.front().empty()) {
            throw InputError("--y: these results vary no second axis to draw over; name an expression");
        }
        return request;
    }

  private:
    static void complete(std::string& text, const std::string& otherwise) {
        if (text.empty()) text = otherwise;
    }
    static void complete(std::vector<std::string>& texts, const std::vector<std::string>& otherwise) {
        if (texts.empty()) texts = otherwise;
    }

    /// Runs of one or two frames have no rate.
    std::string rate() const { return has_rates_ ? kFrameRate : kFrameCycles; }
    std::string figure() const { return is_search_ ? kSmallest : rate(); }

    std::string first_text() const {
        const auto axis =
            std::find_if(axes_.begin(), axes_.end(), [](const VariedAxis& a) { return !a.is_number; });
        return axis != axes_.end() ? axis->column : "";
    }

    std::string first_number() const {
        const auto axis =
            std::find_if(axes_.begin(), axes_.end(), [](const VariedAxis& a) { return a.is_number; });
        return axis != axes_.end() ? axis->column : first_but({});
    }

    /// Also true if an axis that varies together with it is taken.
    bool is_taken(const VariedAxis& axis, const std::set<std::string>& taken) const {
        return std::any_of(axes_.begin(), axes_.end(), [&](const VariedAxis& other) {
            return other.twin == axis.twin && taken.count(other.column) != 0;
        });
    }

    std::string first_but(const std::set<std::string>& taken) const {
        const auto axis = std::find_if(axes_.begin(), axes_.end(),
                                       [&](const VariedAxis& a) { return !is_taken(a, taken); });
        return axis != axes_.end() ? axis->column : "";
    }

    std::string policy() const {
        const auto policy = std::find_if(axes_.begin(), axes_.end(),
                                         [](const VariedAxis& a) { return a.column == kArbitration; });
        if (policy != axes_.end()) return policy->column;
        const std::string text = first_text();
        return !text.empty() ? text : first_but({});
    }

    /// The axes in which points differ and, for a search, the value that it found.
    std::string names() const {
        std::string expression = others({});
        if (is_search_) expression += (expression.empty() ? "" : " || ', ' || ") + std::string(kSmallest);
        return expression;
    }

    /// The axes that are not drawn in another way, as one text: a colour for each combination.
    std::string others(const std::set<std::string>& taken) const {
        std::string expression;
        for (const VariedAxis& axis : axes_) {
            if (axis.twin != axis.column || is_taken(axis, taken)) continue;
            expression += (expression.empty() ? "" : " || ', ' || ") + axis.column;
        }
        return expression;
    }

    bool is_search_;
    std::string cost_;  ///< results of older versions have the bits of the buffers only
    bool has_rates_;
    std::vector<VariedAxis> axes_;
};

/// "a || ', ' || b", which Defaults makes, reads better as "a, b".
std::string colour_title(const std::string& expression, const exploration::ResultsIdentity& identity) {
    std::string title = expression;
    const std::string glue = " || ', ' || ";
    for (std::size_t at = title.find(glue); at != std::string::npos; at = title.find(glue)) {
        title.replace(at, glue.size(), ", ");
    }
    return column_title(title, identity);
}

std::string joined_titles(const std::vector<std::string>& expressions,
                          const exploration::ResultsIdentity& identity) {
    std::string titles;
    for (const std::string& expression : expressions) {
        titles += (titles.empty() ? "" : ", ") + column_title(expression, identity);
    }
    return titles;
}

/// `own_title`: the user's, if not empty.
Json axis_json(const std::string& own_title, const std::string& title,
               const std::vector<std::string>& expressions, bool log) {
    Json axis = {
        {"title", own_title.empty() ? title : own_title},
        {"percent", !expressions.empty() && std::all_of(expressions.begin(), expressions.end(), is_share)}};
    if (log) axis["log"] = true;
    return axis;
}

/// Reads the request's expressions for every point.
class RowReader {
  public:
    RowReader(const ResultsReader& reader, const PlotRequest& request) {
        x_ = add(reader, request.x, "--x");
        for (const std::string& y : request.y) y_.push_back(add(reader, y, "--y").value());
        colour_ = add(reader, request.colour, "--colour");
        facet_ = add(reader, request.facet, "--facet");
        label_ = add(reader, request.label, "--label");
        whole_ = add(reader, exploration::kWhole, "");
        table_ = reader.results(expressions_, request.condition);
    }

    /// One row for each point; with several y, one for each point and each y.
    Json rows(const PlotRequest& request, const exploration::ResultsIdentity& identity) const {
        Json list = Json::array();
        const bool has_panels_by_y = request.chart == ChartKind::kPolicy;
        for (const std::vector<Value>& row : table_.rows) {
            for (std::size_t n = 0; n < std::max<std::size_t>(1, y_.size()); ++n) {
                Json colour = at(row, colour_);
                Json facet = at(row, facet_);
                if (y_.size() > 1) {
                    Json& told_apart = has_panels_by_y ? facet : colour;
                    const std::string name = column_title(request.y[n], identity);
                    told_apart =
                        told_apart.is_null() ? Json(name) : Json(text_of_json(told_apart) + ", " + name);
                }
                Json item = {{"x", at(row, x_)}, {"y", y_.empty() ? Json() : at(row, y_[n])}};
                item["c"] = colour;
                item["f"] = facet;
                item["label"] = at(row, label_);
                if (has_panels_by_y) item["axis"] = {{"percent", is_share(request.y[n])}};
                item["whole"] = at(row, whole_) != 0;
                list.push_back(std::move(item));
            }
        }
        return list;
    }

  private:
    using Column = std::optional<std::size_t>;

    Column add(const ResultsReader& reader, const std::string& expression, const char* option) {
        if (expression.empty()) return {};
        exploration::sql_expression(expression, reader.columns(), option);
        expressions_.push_back(expression);
        return expressions_.size() - 1;
    }
    static Json at(const std::vector<Value>& row, const Column& column) {
        return column ? json_of(row[*column]) : Json();
    }
    static std::string text_of_json(const Json& json) {
        return json.is_string() ? json.get<std::string>() : json.dump();
    }

    std::vector<std::string> expressions_;
    Column x_;
    std::vector<std::size_t> y_;
    Column colour_;
    Column facet_;
    Column label_;
    Column whole_;
    ResultsReader::Table table_;
};

/// The request that charts.js draws.
Json chart_json(const PlotRequest& request, const exploration::ResultsIdentity& identity,
                const RowReader& rows) {
    const bool has_panels_by_y = request.chart == ChartKind::kPolicy && request.y.size() > 1;
    std::string y_title = has_panels_by_y ? "" : joined_titles(request.y, identity);
    if (request.chart == ChartKind::kHistogram) y_title = "points";
    const bool has_colours = !request.colour.empty();
    Json json;
    json["chart"] = chart_names()[static_cast<std::size_t>(request.chart)];
    json["title"] = request.title;
    json["width"] = request.width_pixels;
    json["height"] = request.height_pixels;
    json["x"] = axis_json(request.x_title, column_title(request.x, identity), {request.x}, request.log_x);
    json["y"] = axis_json(request.y_title, y_title, request.y, request.log_y);
    const std::string figure = request.y.size() > 1 && request.chart != ChartKind::kPolicy ? ", figure" : "";
    json["colour"] =
        axis_json(request.colour_title, has_colours ? colour_title(request.colour, identity) + figure : "",
                  {request.colour}, false);
    const std::string facet_title =
        request.facet_title.empty() ? column_title(request.facet, identity) : request.facet_title;
    json["facet"] = {{"title", request.facet.empty() ? "" : facet_title}};
    json["ownScales"] = has_panels_by_y;
    json["references"] = Json::array();
    for (const ReferenceLine& line : request.references) {
        json["references"].push_back({{"value", line.value}, {"label", line.label}});
    }
    json["rows"] = rows.rows(request, identity);
    return json;
}

}  // namespace

const std::vector<std::string>& chart_names() {
    static const std::vector<std::string> names{"lines",  "heatmap",   "pareto",
                                                "policy", "histogram", "scatter"};
    return names;
}

ChartKind chart_of(const std::string& name) {
    const auto found = std::find(chart_names().begin(), chart_names().end(), name);
    if (found == chart_names().end()) {
        throw InputError("--chart: " + text::quoted(name) + " is no chart; use " +
                         text::joined(chart_names(), "or"));
    }
    return static_cast<ChartKind>(std::distance(chart_names().begin(), found));
}

namespace {

/// Refuses options that have no effect on this chart, so that the user does not rely on them. Throws InputError.
void check_options(const PlotRequest& request) {
    const std::string& chart = chart_names()[static_cast<std::size_t>(request.chart)];
    const auto refuse_if = [&chart](bool given, const char* option, const std::string& why) {
        if (given) throw InputError(std::string(option) + ": " + chart + " " + why + "; leave it out");
    };
    const ChartKind kind = request.chart;
    const bool has_bands = kind == ChartKind::kHeatmap || kind == ChartKind::kPolicy;
    refuse_if(request.log_x && has_bands, "--log-x", "has its values side by side along that axis");
    refuse_if(request.log_y && kind == ChartKind::kHeatmap, "--log-y",
              "has its values side by side along that axis");
    refuse_if(!request.references.empty() && kind == ChartKind::kHeatmap, "--reference",
              "has no axis with the figure");
    refuse_if(!request.y.empty() && kind == ChartKind::kHistogram, "--y", "counts points along that axis");
    refuse_if(request.y.size() > 1 && kind == ChartKind::kHeatmap, "--y",
              "has one axis there and takes one expression");
    refuse_if(!request.label.empty() && kind != ChartKind::kPareto, "--label",
              "has no front whose points to name");
    const bool has_usual_colour =
        kind == ChartKind::kLines || kind == ChartKind::kHeatmap || kind == ChartKind::kScatter;
    refuse_if(!request.colour_title.empty() && request.colour.empty() && !has_usual_colour, "--colour-title",
              "has no colours without --colour");
    refuse_if(!request.facet_title.empty() && request.facet.empty(), "--facet-title",
              "has no panels without --facet");
}

}  // namespace

std::string plot_svg(const std::vector<std::filesystem::path>& results, const PlotRequest& open_request) {
    check_options(open_request);
    const ResultsReader reader(results);
    if (!open_request.condition.empty()) {
        exploration::sql_expression(open_request.condition, reader.columns(), "--where");
    }
    if (reader.results({"point"}, open_request.condition).rows.empty()) {
        throw InputError("'" + results.front().string() + "' has no point" +
                         (open_request.condition.empty() ? "s yet" : " for which --where is true") +
                         ": nothing to draw");
    }
    const PlotRequest request = Defaults(reader, open_request).completed(open_request);
    const Json chart = chart_json(request, reader.identity(), RowReader(reader, request));

    std::string script;
    for (const char* const part : {"vega_bundle.js", "scales.js", "charts.js", "plot.js"}) {
        script += embedded_file(part);
        script += '\n';
    }
    script += "metabufferPlot(" + script_text(chart) + ");\n";
    return filtered({{"node", "-"}, "nodejs"}, script);
}

std::string png_of(const std::string& svg) {
    return filtered({{"rsvg-convert", "--zoom", "2", "--format", "png"}, "librsvg2-bin"}, svg);
}

}  // namespace metabuffer::charts
