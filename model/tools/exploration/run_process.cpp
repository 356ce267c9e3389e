#include "tools/exploration/run_process.h"

#include <chrono>
#include <exception>
#include <utility>

#include "host/text.h"
#include "images/image_codec.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/value_json.h"

namespace metabuffer::exploration {
namespace {

using Json = nlohmann::json;

double now_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Value value_from(const Json& json) {
    if (json.is_number_integer()) return json.get<std::int64_t>();
    if (json.is_number()) return json.get<double>();
    if (json.is_string()) return json.get<std::string>();
    return {};
}

RunRecord simulated(const Simulate& simulate, const RunRequest& request) {
    RunRecord record;
    const Scenario scenario = request.scenario->scenario(request.overrides);
    const Simulation simulation = simulate(scenario, request.pictures || request.wrong_pixels);
    const RunReport& report = simulation.report;
    if (!report.watchdog.empty()) {
        record.status = RunStatus::kWatchdog;
        record.reason = text::one_line("nothing moved any more: " + text::joined(report.watchdog, "and"));
    }
    record.figures = figures_of(report, scenario);
    record.report = report_json(report);
    if (!request.pictures) return record;
    for (std::size_t display = 0; display < simulation.pictures.size(); ++display) {
        const ColourImage& picture = simulation.pictures[display];
        if (picture.values.empty()) continue;  // the run ended before it was shown
        record.pictures.emplace_back(static_cast<int>(display) + 1,
                                     image_codec().png(picture, "picture.png"));
    }
    return record;
}

/// Runs it in this process. An error becomes a record, too.
RunRecord outcome_of(const Simulate& simulate, const RunRequest& request) {
    RunRecord failed;
    try {
        return simulated(simulate, request);
    } catch (const InputError& error) {
        failed.status = RunStatus::kInvalid;
        failed.reason = text::one_line(error.what());
    } catch (const std::exception& error) {
        failed.status = RunStatus::kFailed;
        failed.reason = text::one_line(error.what());
    }
    return failed;
}

std::vector<std::uint8_t> packed(const RunRecord& record) {
    Json figures = Json::array();
    for (const Value& value : record.figures) figures.push_back(json_of<Json>(value));
    Json pictures = Json::array();
    for (const auto& [display, png] : record.pictures) {
        pictures.push_back({display, Json::binary({png.begin(), png.end()})});
    }
    // Reasons have names of files, which need not be UTF-8. As bytes they may hold anything.
    return Json::to_cbor({{"status", to_string(record.status)},
                          {"reason", Json::binary({record.reason.begin(), record.reason.end()})},
                          {"figures", std::move(figures)},
                          {"report", record.report},
                          {"pictures", std::move(pictures)}});
}

std::string text_from(const Json& bytes) {
    const auto& binary = bytes.get_binary();
    return {binary.begin(), binary.end()};
}

RunRecord unpacked(const std::string& bytes) {
    const Json json = Json::from_cbor(bytes);
    RunRecord record;
    record.status = run_status_of(json.at("status").get<std::string>());
    record.reason = text_from(json.at("reason"));
    for (const Json& value : json.at("figures")) record.figures.push_back(value_from(value));
    record.report = json.at("report").get<std::string>();
    for (const Json& picture : json.at("pictures")) {
        record.pictures.emplace_back(picture.at(0).get<int>(), text_from(picture.at(1)));
    }
    return record;
}

}  // namespace

RunProcess::RunProcess(const Simulate& simulate, RunRequest request)
    : request_(std::move(request)),
      started_seconds_(now_seconds()),
      process_(std::make_unique<ChildProcess>([this, &simulate](const ChildProcess::Sender& sender) {
          const std::vector<std::uint8_t> bytes = packed(outcome_of(simulate, request_));
          sender.send(bytes.data(), bytes.size());
      })) {}

double RunProcess::seconds() const { return now_seconds() - started_seconds_; }

void RunProcess::give_up(const std::string& reason) {
    process_.reset();
    given_up_ = reason;
}

RunRecord RunProcess::record() const {
    RunRecord record;
    if (process_ == nullptr) {
        record.status = RunStatus::kCrashed;
        record.reason = given_up_;
    } else if (process_->complaint().empty() && !received_.empty()) {
        record = unpacked(received_);
    } else {
        record.status = RunStatus::kCrashed;
        record.reason =
            "its process " +
            (process_->complaint().empty() ? std::string("ended without a report") : process_->complaint());
    }
    record.settings = request_.settings;
    record.wall_seconds = seconds();
    return record;
}

}  // namespace metabuffer::exploration
