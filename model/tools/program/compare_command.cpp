#include "tools/program/compare_command.h"

#include <fmt/format.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/child_process.h"
#include "host/errors.h"
#include "host/text.h"
#include "report/report_difference.h"
#include "scenario/fault_keys.h"
#include "tools/program/level_process.h"
#include "tools/program/progress_line.h"

namespace metabuffer {
namespace {

using text::counted;

constexpr std::size_t kMostLines = 100;
/// How far one level may run ahead of the other, in pixels of pictures that wait for their counterparts.
constexpr std::size_t kMostPixelsAhead = std::size_t{1} << 24;

constexpr const char* kCompareFooter =
    "Compares every value of report.json but `level`, and every frame's picture on every display. Prints\n"
    "`identical` and what was compared, or each difference on a line.\n"
    "Examples:\n"
    "  metabuffer compare scenarios/paper-figure.yaml\n"
    "  metabuffer compare scenarios/paper-figure.yaml --set bus.arbitration=edf --frames 4 --no-images\n"
    "Exit status: 0 identical, also if the watchdog ended the run at both levels; 1 a level failed; 2 bad\n"
    "input; 5 the levels differ.";

/// Pictures of both levels, each compared with its counterpart as soon as both have arrived.
class PictureComparison {
  public:
    void take(TimedLevel level, LevelProcess::Picture picture) {
        Waiting& others = waiting_of(level == TimedLevel::kRtl ? TimedLevel::kTlm : TimedLevel::kRtl);
        const PictureKey key{picture.frame, picture.display};
        const auto counterpart = others.pictures.find(key);
        if (counterpart == others.pictures.end()) {
            Waiting& own = waiting_of(level);
            own.pixels += picture.image.values.size();
            own.pictures.emplace(key, std::move(picture.image));
            return;
        }
        const bool is_rtl = level == TimedLevel::kRtl;
        compare(key, is_rtl ? &picture.image : &counterpart->second,
                is_rtl ? &counterpart->second : &picture.image);
        others.pixels -= counterpart->second.values.size();
        others.pictures.erase(counterpart);
    }

    /// Call it after the last picture: it compares those that have no counterpart.
    void finish() {
        for (const auto& [key, image] : rtl_.pictures) compare(key, &image, nullptr);
        for (const auto& [key, image] : tlm_.pictures) compare(key, nullptr, &image);
    }

    bool is_far_ahead(TimedLevel level) { return waiting_of(level).pixels > kMostPixelsAhead; }
    /// By frame and display.
    std::vector<std::string> differences() const {
        std::vector<std::string> lines;
        lines.reserve(differences_.size());
        std::transform(differences_.begin(), differences_.end(), std::back_inserter(lines),
                       [](const auto& difference) { return difference.second; });
        return lines;
    }
    std::size_t compared() const { return compared_; }

  private:
    using PictureKey = std::pair<int, int>;  ///< frame and display

    struct Waiting {
        std::multimap<PictureKey, ColourImage> pictures;
        std::size_t pixels = 0;
    };

    Waiting& waiting_of(TimedLevel level) { return level == TimedLevel::kRtl ? rtl_ : tlm_; }

    void compare(const PictureKey& key, const ColourImage* rtl, const ColourImage* tlm) {
        ++compared_;
        const auto difference = picture_difference(key.second, key.first, rtl, tlm);
        if (difference) differences_.emplace(key, *difference);
    }

    Waiting rtl_;
    Waiting tlm_;
    std::multimap<PictureKey, std::string> differences_;
    std::size_t compared_ = 0;
};

void show_progress(const ProgressLine& line, const LevelProcess& rtl, const LevelProcess& tlm) {
    line.show(fmt::format("rtl {:3.0f} %, tlm {:3.0f} % of the pixels composited", 100.0 * rtl.progress(),
                          100.0 * tlm.progress()));
}

/// Follows both runs to their ends and compares their pictures as they arrive.
void receive_all(LevelProcess& rtl, LevelProcess& tlm, PictureComparison& pictures,
                 const ProgressLine& progress) {
    while (!rtl.ended() || !tlm.ended()) {
        // A level that is far ahead waits for the other, unless that one is far ahead as well: they may show
        // quite different frames.
        const bool rtl_waits = pictures.is_far_ahead(TimedLevel::kRtl) && !tlm.ended() &&
                               !pictures.is_far_ahead(TimedLevel::kTlm);
        const bool tlm_waits = pictures.is_far_ahead(TimedLevel::kTlm) && !rtl.ended() &&
                               !pictures.is_far_ahead(TimedLevel::kRtl);
        // poll() ignores a negative descriptor.
        std::array<pollfd, 2> polled{
            {{rtl_waits ? -1 : rtl.descriptor(), POLLIN, 0}, {tlm_waits ? -1 : tlm.descriptor(), POLLIN, 0}}};
        if (poll(polled.data(), polled.size(), -1) < 0 && errno != EINTR) {
            throw InputError("metabuffer: the runs cannot be followed: " +
                             std::generic_category().message(errno));
        }
        for (LevelProcess* const process : {&rtl, &tlm}) {
            if (polled[process == &rtl ? 0 : 1].revents == 0) continue;
            for (LevelProcess::Picture& picture : process->receive()) {
                pictures.take(process->level(), std::move(picture));
            }
        }
        show_progress(progress, rtl, tlm);
    }
    pictures.finish();
}

/// Which levels failed, and how. At least one must have failed.
std::string failures_text(const LevelProcess& rtl, const LevelProcess& tlm) {
    const auto& at_rtl = rtl.failure();
    const auto& at_tlm = tlm.failure();
    if (at_rtl && at_tlm && at_rtl->message == at_tlm->message) {
        return "both levels failed: " + at_rtl->message;
    }
    std::string text;
    if (at_rtl) text += "level rtl failed: " + at_rtl->message;
    if (at_rtl && at_tlm) text += "; ";
    if (at_tlm) text += "level tlm failed: " + at_tlm->message;
    return text;
}

/// How much of the two runs was compared.
std::string extent(const Scenario& scenario, std::int64_t core_cycles, const ReportComparison& reports,
                   const PictureComparison& pictures, bool no_images) {
    const auto displays = static_cast<std::size_t>(scenario.displays.count());
    return counted(static_cast<std::size_t>(scenario.frames), "frame") + " on " +
           counted(displays, "display") + ", " + counted(scenario.renderers.size() * displays, "composer") +
           ", " + counted(static_cast<std::size_t>(core_cycles), "core clock") + ": " +
           counted(reports.values, "value") + " of the report, " +
           (no_images ? "no pictures" : counted(pictures.compared(), "picture")) + " compared";
}

void print_times(const LevelProcess& rtl, const LevelProcess& tlm) {
    const double rtl_seconds = rtl.result()->simulation_seconds;
    const double tlm_seconds = tlm.result()->simulation_seconds;
    std::printf("simulated in %.4f s by rtl, %.4f s by tlm", rtl_seconds, tlm_seconds);
    if (rtl_seconds > 0.0 && tlm_seconds > 0.0) std::printf(": ratio %.1f", rtl_seconds / tlm_seconds);
    std::printf("\n");
}

}  // namespace

CompareCommand::CompareCommand(CLI::App& program)
    : Command(program, "compare", "Run a scenario at levels rtl and tlm; report where they differ"),
      scenario_(command()) {
    command().add_flag("--no-images", no_images_, "Compare the counters only");
    command().add_flag("--quiet", quiet_, "Print nothing but differences");
    command().footer(kCompareFooter);
}

ExitStatus CompareCommand::execute() {
    Scenario scenario = scenario_.load();
    // Checked before level rtl runs, which takes longer.
    refuse_faults_of_level_rtl(scenario, to_string(TimedLevel::kTlm));
    PictureComparison pictures;
    // All processes of this computer read the images, and those of both levels find them in memory.
    read_images_ahead(scenario, helper_process_count());
    read_images(scenario);
    LevelProcess rtl(TimedLevel::kRtl, scenario, !no_images_);
    LevelProcess tlm(TimedLevel::kTlm, scenario, !no_images_);
    receive_all(rtl, tlm, pictures, ProgressLine(!quiet_));

    if (rtl.failure() || tlm.failure()) {
        std::cerr << text::message(scenario_.file() + ": " + failures_text(rtl, tlm)) << '\n';
        const bool model_error = (rtl.failure() && rtl.failure()->status == kExitModelError) ||
                                 (tlm.failure() && tlm.failure()->status == kExitModelError);
        return model_error ? kExitModelError : (rtl.failure() ? *rtl.failure() : *tlm.failure()).status;
    }

    const ReportComparison reports = compare_reports(rtl.result()->report, tlm.result()->report);
    std::vector<std::string> lines = reports.differences;
    const std::vector<std::string> picture_lines = pictures.differences();
    lines.insert(lines.end(), picture_lines.begin(), picture_lines.end());
    for (std::size_t i = 0; i < std::min(lines.size(), kMostLines); ++i) std::cout << lines[i] << '\n';
    if (lines.size() > kMostLines) std::cout << "... and " << lines.size() - kMostLines << " more\n";
    if (!quiet_) {
        std::cout << (lines.empty() ? std::string("identical") : counted(lines.size(), "difference")) << "; "
                  << extent(scenario, rtl.result()->core_cycles, reports, pictures, no_images_) << '\n';
        if (rtl.result()->watchdog_tripped && tlm.result()->watchdog_tripped) {
            std::cout << "the watchdog ended the run at both levels\n";
        }
        std::cout.flush();
        print_times(rtl, tlm);
    }
    return lines.empty() ? kExitDone : kExitDifferent;
}

}  // namespace metabuffer
