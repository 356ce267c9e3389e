#include "requests.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "host/child_process.h"
#include "host/errors.h"
#include "host/text.h"
#include "report/report.h"
#include "scenario/scenario_writer.h"
#include "tools/analysis/analysis_report.h"
#include "tools/analysis/bandwidth_analysis.h"
#include "tools/charts/column_title.h"
#include "tools/exploration/results_database.h"
#include "tools/exploration/value_json.h"
#include "tools/program/exploration_run.h"
#include "tools/program/failure.h"
#include "tools/program/level_run.h"
#include "tools/program/option_ranges.h"
#include "tools/program/results_table.h"
#include "tools/program/sizing.h"

namespace metabuffer::python {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// The enumerator of this name, or the usual one if the name is empty.
template <typename Level>
Level level_of(const std::string& name, Level usual) {
    if (name.empty()) return usual;
    const std::optional<Level> level = from_name<Level>(name);
    if (level) return *level;
    throw InputError("level: " + text::quoted(name) + " is not " + EnumNames<Level>::kWhat + "; use " +
                     text::joined(enum_names<Level>(), "or"));
}

template <typename Number, typename Range>
void check_range(const char* name, Number value, const Range& range) {
    if (!range.contains(value)) {
        throw InputError(std::string(name) + ": " + text::out_of_range(value, range));
    }
}

Scenario scenario_of(const Source& source, const std::vector<ScenarioOverride>& overrides) {
    return source.text ? parse_scenario(*source.text, source.file, std::filesystem::current_path(), overrides)
                       : load_scenario(source.file, overrides);
}

/// The displays' pictures in a file: one display after the other, and the frames of each in order. A frame that is not
/// shown leaves its part of the file empty.
class PictureFile {
  public:
    PictureFile(int descriptor, const Scenario& scenario)
        : descriptor_(descriptor),
          frames_(scenario.frames),
          bytes_(std::int64_t{3} * scenario.displays.width_pixels * scenario.displays.height_pixels),
          shown_(static_cast<std::size_t>(scenario.displays.count())) {}

    void take(int frame, int display, const ColourImage& picture) {
        packed_.clear();
        packed_.reserve(picture.values.size() * 3);
        for (const std::uint32_t colour : picture.values) {
            for (const int shift : {16, 8, 0}) packed_.push_back(static_cast<char>(colour >> shift & 0xFFU));
        }
        const std::int64_t index = std::int64_t{display - 1} * frames_ + frame;
        std::size_t written = 0;
        while (written < packed_.size()) {
            const ssize_t count = pwrite(descriptor_, packed_.data() + written, packed_.size() - written,
                                         index * bytes_ + static_cast<std::int64_t>(written));
            if (count < 0 && errno == EINTR) continue;
            if (count <= 0) fail();
            written += static_cast<std::size_t>(count);
        }
        int& shown = shown_[static_cast<std::size_t>(display) - 1];
        shown = std::max(shown, frame + 1);
    }

    /// The frames of each display up to the last one shown.
    const std::vector<int>& shown() const { return shown_; }

    /// Makes the file as large as if every frame had been shown.
    void finish() const {
        const std::int64_t pictures = static_cast<std::int64_t>(shown_.size()) * frames_;
        if (ftruncate(descriptor_, pictures * bytes_) != 0) fail();
    }

  private:
    [[noreturn]] static void fail() {
        throw OutputError("metabuffer: pictures cannot be kept: " + std::generic_category().message(errno));
    }

    int descriptor_;
    std::int64_t frames_;
    std::int64_t bytes_;
    std::vector<int> shown_;
    std::string packed_;
};

Reply table_of(const std::string& file, const std::string& where, const std::string& columns) {
    const exploration::ResultsReader reader(file);
    const exploration::ResultsReader::Table table = results_table(reader, where, columns);
    Json units = Json::object();
    for (const std::string& column : table.columns) {
        const std::string unit = charts::column_unit(column);
        if (!unit.empty()) units[column] = unit;
    }
    Json rows = Json::array();
    for (const std::vector<exploration::Value>& row : table.rows) {
        Json cells = Json::array();
        for (const exploration::Value& value : row) cells.push_back(exploration::json_of<Json>(value));
        rows.push_back(std::move(cells));
    }
    const exploration::ResultsIdentity& identity = reader.identity();
    return {kExitDone, text_of({{"columns", table.columns},
                                {"rows", std::move(rows)},
                                {"units", std::move(units)},
                                {"name", identity.name},
                                {"scenario", identity.scenario},
                                {"level", identity.level},
                                {"keys", identity.keys},
                                {"search_key", identity.search_key},
                                {"goal", identity.goal}})};
}

Reply explored(const exploration::SweepPlan& plan, const ExplorationCall& call,
               const std::function<exploration::KnownAnswer(const Scenario&)>& known) {
    ProcessOptions processes;
    processes.level = level_of<TimedLevel>(call.level, TimedLevel::kTlm);
    if (call.processes) {
        check_range("processes", std::int64_t{*call.processes}, kProcesses);
        processes.processes = *call.processes;
    }
    if (call.time_limit_seconds) {
        check_range("time_limit", *call.time_limit_seconds, kTimeLimitSeconds);
        processes.time_limit_seconds = *call.time_limit_seconds;
    }
    {
        const exploration::Exploration exploration =
            run_exploration(plan, call.results, processes, call.quiet, false, known);
        const Failure failure = verdict(exploration);
        if (failure.status != kExitDone) return {failure.status, failure.message};
    }
    return table_of(call.results, "", "");
}

}  // namespace

Reply run(const RunCall& call) {
    LevelRequest request;
    request.level = level_of<RunLevel>(call.level, call.check ? RunLevel::kRtl : RunLevel::kTlm);
    request.images = call.images;
    request.check = call.check;
    check_request(request);
    Scenario scenario = scenario_of(call.scenario, call.overrides);
    if (needs_pixels(request)) read_images_ahead(scenario, helper_process_count());
    const std::string effective = effective_scenario(scenario, std::filesystem::current_path());
    PictureFile pictures(call.pictures, scenario);
    const auto take = [&pictures](int frame, int display, const ColourImage& picture) {
        pictures.take(frame, display, picture);
    };
    LevelOutcome outcome;
    try {
        run_level(scenario, request, {take, {}}, outcome);
    } catch (...) {
        const Failure failure = current_failure();
        return {failure.status, violations_text(outcome, call.scenario.file) + failure.message};
    }
    pictures.finish();
    const Judgement judgement = judge(outcome, call.scenario.file, false);
    return {judgement.status, text_of({{"report", report_json(outcome.report)},
                                       {"summary", report_summary(outcome.report)},
                                       {"effective_scenario", effective},
                                       {"simulation_seconds", outcome.simulation_seconds},
                                       {"frames", scenario.frames},
                                       {"width", scenario.displays.width_pixels},
                                       {"height", scenario.displays.height_pixels},
                                       {"columns", scenario.displays.columns},
                                       {"shown", pictures.shown()},
                                       {"judgement", judgement.text}})};
}

Reply analyze(const Source& scenario, const std::vector<ScenarioOverride>& overrides,
              std::optional<double> frame_rate_hz) {
    if (frame_rate_hz) check_range("frame_rate_hz", *frame_rate_hz, kFrameRatesHz);
    const Scenario loaded = scenario_of(scenario, overrides);
    return {kExitDone, analysis::analysis_json(analysis::analyze(loaded, {std::nullopt, frame_rate_hz}))};
}

Reply sweep(const Source& sweep, const ExplorationCall& call) {
    const exploration::SweepPlan plan = make_plan(
        sweep.text ? exploration::parse_sweep(*sweep.text, sweep.file, std::filesystem::current_path())
                   : exploration::load_sweep(sweep.file));
    return explored(plan, call, {});
}

Reply size(const SizeCall& call, const ExplorationCall& exploration) {
    SizeRequest request;
    request.file = call.scenario;
    request.overrides = call.overrides;
    request.minimize = {call.minimize};
    request.over = call.over;
    request.goal = call.goal;
    request.frame_rate_hz = call.frame_rate_hz;
    if (call.frame_rate_hz) check_range("frame_rate_hz", *call.frame_rate_hz, kFrameRatesHz);
    if (call.checks) {
        check_range("checks", std::int64_t{*call.checks}, kChecks);
        request.checks = *call.checks;
    }
    const exploration::SweepPlan plan = make_plan(describe_size(request));
    check_frames(request, plan);
    return explored(plan, exploration, [&request, &plan](const Scenario& scenario) {
        return known_answer(request, scenario, *plan.search);
    });
}

Reply results(const std::string& file, const std::string& where, const std::string& columns) {
    return table_of(file, where, columns);
}

}  // namespace metabuffer::python
