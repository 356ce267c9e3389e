#include "tools/charts/report_page.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "host/errors.h"
#include "host/text.h"
#include "tools/charts/base64.h"
#include "tools/charts/column_title.h"
#include "tools/charts/embedded_files.h"
#include "tools/charts/page_template.h"
#include "tools/charts/value_json.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/results_database.h"

namespace metabuffer::charts {

namespace {

using exploration::ResultsReader;
using exploration::Value;

/// The most simulations of searches in a page. Charts of more would be slow and show nothing new.
constexpr std::size_t kMostSimulations = 20'000;

constexpr const char* kWallSeconds = "wall_seconds";

/// Where the columns of a table are, by name.
class Columns {
  public:
    explicit Columns(const std::vector<std::string>& names) {
        for (std::size_t n = 0; n < names.size(); ++n) columns_[names[n]] = n;
    }
    /// An empty value if there is no such column.
    Value in(const std::vector<Value>& row, const std::string& name) const {
        const auto column = columns_.find(name);
        return column == columns_.end() ? Value() : row[column->second];
    }

  private:
    std::map<std::string, std::size_t> columns_;
};

/// One file, the points of it that the page shows, and where they are in the page.
struct Source {
    Source(const std::filesystem::path& file_in, const std::string& condition)
        : file(file_in), reader(file_in) {
        if (!condition.empty()) exploration::sql_expression(condition, reader.columns(), "--where");
        if (const std::int64_t count = reader.count(condition); count > kMostPagePoints) {
            throw InputError("'" + file.string() + "' has " + std::to_string(count) +
                             " points to show, and a page takes at most " + std::to_string(kMostPagePoints) +
                             "; use --where");
        }
        points = reader.results(condition);
    }

    const std::vector<std::string>& keys() const { return reader.identity().keys; }
    /// A point's settings, in the order of keys().
    std::vector<Value> settings(const std::vector<Value>& row) const {
        // The settings follow the point's number, some under other names than their keys.
        const auto first = row.begin() + 1;
        return {first, first + static_cast<std::ptrdiff_t>(keys().size())};
    }

    /// The settings of a run, as texts by their keys. Throws InputError if the file holds something else.
    Json run_settings(const std::string& text) const {
        Json settings = Json::parse(text, nullptr, false);
        const bool are_texts =
            settings.is_object() && std::all_of(settings.begin(), settings.end(),
                                                [](const Json& value) { return value.is_string(); });
        if (are_texts) return settings;
        throw InputError("'" + file.string() + "' is damaged: the settings of a run are " +
                         text::quoted(text));
    }

    std::filesystem::path file;
    ResultsReader reader;
    ResultsReader::Table points;
};

/// Builds the data that the page's script reads. Points and simulations are lists instead of objects, since there may
/// be thousands.
class PageData {
  public:
    explicit PageData(std::vector<Source>& sources) : sources_(sources) {
        for (const Source& source : sources_) {
            for (const std::string& key : source.keys()) {
                if (std::find(axes_.begin(), axes_.end(), key) == axes_.end()) axes_.push_back(key);
            }
        }
        for (const exploration::FigureKind& kind : exploration::figure_kinds())
            figures_.emplace_back(kind.name);
        figures_.emplace_back(kWallSeconds);
    }

    Json json(const PageOptions& options) {
        Json data;
        data["condition"] = options.condition;
        data["sources"] = sources_json();
        data["axes"] = axes_;
        data["figures"] = figures_json();
        data["points"] = points_json();
        data["simulations"] = simulations_json();
        data["embedded"] = embedded_json(options.most_embedded_bytes);
        data["left_out"] = {{"simulations", simulations_left_out_},
                            {"reports", reports_left_out_},
                            {"pictures", pictures_left_out_},
                            {"mebibytes", options.most_embedded_bytes / kBytesPerMebibyte}};
        return data;
    }

  private:
    Json sources_json() const {
        Json list = Json::array();
        for (const Source& source : sources_) {
            const exploration::ResultsIdentity& identity = source.reader.identity();
            Json fixed = Json::array();
            for (const exploration::Setting& setting : identity.fixed) {
                fixed.push_back({setting.key, json_of(exploration::value_of_setting(setting.value))});
            }
            list.push_back({{"file", source.file.filename().string()},
                            {"name", identity.name},
                            {"level", identity.level},
                            {"scenario", identity.scenario},
                            {"base", identity.base},
                            {"fixed", std::move(fixed)},
                            {"search_key", identity.search_key},
                            {"goal", identity.goal}});
        }
        return list;
    }

    Json figures_json() const {
        Json list = Json::array();
        const auto& kinds = exploration::figure_kinds();
        for (const std::string& name : figures_) {
            const std::optional<std::size_t> figure = exploration::figure_index(name);
            list.push_back(
                {{"name", name},
                 {"title", column_title(name, {})},
                 {"unit", figure ? kinds[*figure].unit : "s"},
                 {"meaning", figure ? kinds[*figure].meaning : "from the process's start to its end"},
                 {"percent", is_share(name)}});
        }
        return list;
    }

    /// The values of a row for the page's axes; null for an axis that its file does not have.
    Json axes_json(const Source& source, const std::vector<Value>& settings) const {
        Json list = Json::array();
        for (const std::string& axis : axes_) {
            const auto key = std::find(source.keys().begin(), source.keys().end(), axis);
            const auto n = static_cast<std::size_t>(std::distance(source.keys().begin(), key));
            list.push_back(key == source.keys().end() ? Json() : json_of(settings[n]));
        }
        return list;
    }

    Json figure_values(const Columns& columns, const std::vector<Value>& row) const {
        Json list = Json::array();
        for (const std::string& name : figures_) list.push_back(json_of(columns.in(row, name)));
        return list;
    }

    Json points_json() const {
        Json list = Json::array();
        for (std::size_t s = 0; s < sources_.size(); ++s) {
            const Source& source = sources_[s];
            const Columns columns(source.points.columns);
            for (const std::vector<Value>& row : source.points.rows) {
                Json point = Json::array({s});
                for (const char* name :
                     {"point", "run", "status", "reason", "smallest", "monotonic", "runs", "note"}) {
                    point.push_back(json_of(columns.in(row, name)));
                }
                point.push_back(axes_json(source, source.settings(row)));
                point.push_back(figure_values(columns, row));
                list.push_back(std::move(point));
            }
        }
        return list;
    }

    /// Every simulation of those searches that have points in the page.
    Json simulations_json() {
        Json list = Json::array();
        for (std::size_t s = 0; s < sources_.size(); ++s) {
            const Source& source = sources_[s];
            if (source.reader.identity().search_key.empty()) continue;
            std::set<std::vector<Value>> shown;
            for (const auto& row : source.points.rows) shown.insert(source.settings(row));
            const ResultsReader::Table runs = source.reader.runs();
            const Columns columns(runs.columns);
            for (const std::vector<Value>& row : runs.rows) {
                const Json texts = source.run_settings(exploration::text_of(columns.in(row, "settings")));
                std::vector<Value> settings;
                for (const std::string& key : source.keys()) {
                    settings.push_back(exploration::value_of_setting(texts.value(key, std::string())));
                }
                if (shown.count(settings) == 0) continue;
                if (list.size() >= kMostSimulations) {
                    ++simulations_left_out_;
                    continue;
                }
                const std::string looked_at = texts.value(source.reader.identity().search_key, std::string());
                list.push_back(Json::array(
                    {s, json_of(columns.in(row, "id")), json_of(columns.in(row, "status")),
                     json_of(columns.in(row, "reason")), json_of(exploration::value_of(looked_at)),
                     axes_json(source, settings), figure_values(columns, row)}));
            }
        }
        return list;
    }

    /// Reports and pictures by "source:run". Reports come first, and take at most half of the room.
    Json embedded_json(std::size_t room) {
        Json embedded = Json::object();
        std::size_t left = room;
        for_each_run([&](const ResultsReader& reader, std::int64_t run, const std::string& name) {
            if (reports_left_out_ > 0) {  // no need to read more
                ++reports_left_out_;
                return;
            }
            const std::string report = reader.report(run);
            if (report.empty()) return;
            std::string text = base64(deflated(report));
            if (text.size() > left || (room - left) + text.size() > room / 2) {
                ++reports_left_out_;
                return;
            }
            left -= text.size();
            embedded[name]["report"] = std::move(text);
        });
        for_each_run([&](const ResultsReader& reader, std::int64_t run, const std::string& name) {
            for (const auto& [display, png] : reader.pictures(run)) {
                std::string text = base64(png);
                if (text.size() > left || pictures_left_out_ > 0) {
                    ++pictures_left_out_;
                    continue;
                }
                left -= text.size();
                embedded[name]["pictures"].push_back(Json::array({display, std::move(text)}));
            }
        });
        return embedded;
    }

    template <typename Action>
    void for_each_run(Action action) {
        for (std::size_t s = 0; s < sources_.size(); ++s) {
            const Columns columns(sources_[s].points.columns);
            for (const std::vector<Value>& row : sources_[s].points.rows) {
                const Value run = columns.in(row, "run");
                if (const auto* number = std::get_if<std::int64_t>(&run)) {
                    action(sources_[s].reader, *number, std::to_string(s) + ":" + std::to_string(*number));
                }
            }
        }
    }

    std::vector<Source>& sources_;
    std::vector<std::string> axes_;
    std::vector<std::string> figures_;
    std::size_t simulations_left_out_ = 0;
    std::size_t reports_left_out_ = 0;
    std::size_t pictures_left_out_ = 0;
};

std::string default_title(const std::vector<Source>& sources) {
    std::string title;
    for (const Source& source : sources) {
        const std::string& name = source.reader.identity().name;
        title += (title.empty() ? "" : ", ") + (name.empty() ? source.file.filename().string() : name);
    }
    return title;
}

}  // namespace

std::string report_page(const std::vector<std::filesystem::path>& files, const PageOptions& options) {
    std::vector<Source> sources;
    sources.reserve(files.size());
    for (const std::filesystem::path& file : files) sources.emplace_back(file, options.condition);
    const Json data = PageData(sources).json(options);
    const std::string title = html_text(options.title.empty() ? default_title(sources) : options.title);
    const std::string data_text = script_text(data);
    return filled(embedded_file("page.html"), {{"TITLE", title},
                                               {"STYLE", embedded_file("page.css")},
                                               {"DATA", data_text},
                                               {"VEGA", embedded_file("vega_bundle.js")},
                                               {"SCALES", embedded_file("scales.js")},
                                               {"CHARTS", embedded_file("charts.js")},
                                               {"ELEMENTS", embedded_file("elements.js")},
                                               {"PAGE_DATA", embedded_file("page_data.js")},
                                               {"PAGE_POINT", embedded_file("page_point.js")},
                                               {"PAGE", embedded_file("page.js")}});
}

}  // namespace metabuffer::charts
