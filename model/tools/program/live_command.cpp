#include "tools/program/live_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <iostream>
#include <memory>
#include <optional>

#include "application/metabuffer_host.h"
#include "host/errors.h"
#include "host/text.h"
#include "live/live_wall.h"
#include "report/report.h"
#include "scenario/limits.h"
#include "scenario/scenario_writer.h"
#include "tools/program/output_guard.h"
#include "tools/program/result_folder.h"
#include "tools/program/stop_signals.h"
#include "tools/program/wall_screen.h"

namespace metabuffer {
namespace {

constexpr const char* kPictures = "--pictures";
constexpr const char* kLiveFooter =
    "Renderers of the scenario that have the key live wait for their applications, which connect through\n"
    "metabuffer_host.h or by metabuffer-gl. It ends after --frames, at Ctrl-C, or when every application\n"
    "has gone, with report and pictures as run writes them. What was recorded runs again by metabuffer run.\n"
    "Examples:\n"
    "  metabuffer live scenarios/live/two-programs.yaml\n"
    "  metabuffer live scenarios/live/two-programs.yaml --level rtl --no-window --record recorded\n"
    "  metabuffer live scenarios/live/two-programs.yaml --no-window --stream - |\n"
    "      ffplay -f rawvideo -pixel_format rgb24 -video_size 640x480 -\n"
    "Exit status: 0 done; 1 the model failed; 2 bad input, or no application has sent a pair; 3 --strict "
    "and\n"
    "something starved or was rejected; 4 the watchdog: nothing moved any more.";

}  // namespace

LiveCommand::LiveCommand(CLI::App& program)
    : Command(program, "live", "Show what applications draw, as the machine composites it"),
      scenario_(command()) {
    command()
        .add_option("--level", level_, "tlm, rtl or functional, as for run (default: tlm)")
        ->check(CLI::IsMember(enum_names<RunLevel>()));
    command().add_option("--socket", socket_,
                         "Where applications connect (default: $XDG_RUNTIME_DIR/metabuffer-NAME.sock)");
    command()
        .add_option("--wait", wait_seconds_,
                    "Seconds that a link in lockstep waits for its application before a pair is missing "
                    "(default 10)")
        ->check(CLI::Range(0.0, 1e6));
    command().add_flag("--real-time", real_time_,
                       "Free-running links keep to real time, if the model is fast enough");
    command().add_option("--record", record_directory_,
                         "Keep what came as a scenario with images, DIR/scenario.yaml, which run repeats");
    command().add_option("--stream", stream_file_,
                         "Write each frame of the wall as raw video, R G B, to FILE or, with -, to standard "
                         "output");
    command().add_option(kPictures, pictures_,
                         "Which pictures are written, as for run: last (default), all, none, or frames such "
                         "as 2 or 2-5");
    command().add_option("--out", out_directory_, "Directory for the results (default: out/NAME)");
    command().add_flag("--no-window", no_window_, "Show no window");
    command().add_flag("--strict", strict_,
                       "Exit with 3 if a pixel starved or a frame, row or slot table was rejected");
    command().add_flag("--quiet", quiet_, "Print no summary, and not who comes and goes");
    command().footer(kLiveFooter);
}

std::filesystem::path LiveCommand::socket_of(const Scenario& scenario) const {
    if (!socket_.empty()) return socket_;
    std::array<char, METABUFFER_PATH_BYTES> path{};
    if (metabuffer_default_socket(scenario.name.c_str(), path.data(), path.size()) != METABUFFER_OK) {
        throw InputError("--socket: the scenario's name is too long for a socket; use --socket PATH");
    }
    return path.data();
}

ExitStatus LiveCommand::execute() {
    Scenario scenario = scenario_.load(LiveRenderers::kAccepted);
    const auto is_live = [](const Renderer& renderer) { return renderer.is_live; };
    if (std::none_of(scenario.renderers.begin(), scenario.renderers.end(), is_live)) {
        throw InputError(text::located(scenario_.file(),
                                       "no renderer is live; use metabuffer run, or the key live in place of "
                                       "a renderer's frames"));
    }
    // Level tlm can count without pixels. How a wall of free-running links can end depends on what has been shown.
    const bool shows = !no_window_ || !stream_file_.empty() || !names_no_picture(pictures_);
    const auto level = *from_name<RunLevel>(level_);
    const bool only_counts = !shows && level == RunLevel::kTlm && scenario.pacing == Pacing::kLockstep;
    const LevelRequest request{level, !only_counts, false, std::nullopt};
    if (!scenario_.names_frames()) scenario.frames = static_cast<int>(limits::kFrames.high);

    const std::vector<std::filesystem::path> inputs = inputs_of(scenario_.file(), scenario);
    ResultFolder folder(out_directory_.empty() ? std::filesystem::path("out") / scenario.name
                                               : std::filesystem::path(out_directory_),
                        inputs);
    PictureSink pictures(folder, scenario, parse_picture_choice(kPictures, pictures_, scenario.frames));
    const StopSignals signals;
    WallScreen screen(scenario, stream_file_, !no_window_);
    const std::filesystem::path socket = socket_of(scenario);
    live::LiveOptions options;
    options.socket = socket;
    options.wait = std::chrono::duration<double>(wait_seconds_);
    options.keeps_pairs = !record_directory_.empty();
    options.needs_pixels = needs_pixels(request) || options.keeps_pairs;
    options.real_time = real_time_;
    options.stop_descriptor = signals.descriptor();
    if (!quiet_) options.on_event = [](const std::string& line) { std::cerr << line << std::endl; };
    options.on_wait = [&screen] { screen.poll(); };
    const auto wall = std::make_shared<live::LiveWall>(scenario, std::move(options));
    screen.when_closed([&wall] { wall->end(); });
    scenario.live_pairs = wall;
    if (!screen.why_no_window().empty()) {
        std::cerr << "no window: " << screen.why_no_window() << std::endl;
    }
    if (!quiet_) std::cerr << "waiting for applications at " << socket.string() << std::endl;

    RunFollower follower;
    follower.on_shown = [&](const DisplayedFrame& displayed, const std::vector<std::size_t>& wrong_pixels) {
        pictures.take(displayed.frame, displayed.display, displayed.picture);
        screen.take(displayed, wrong_pixels);
        wall->frame_shown(displayed.frame, displayed.pairs);
    };
    LevelOutcome outcome;
    run_level(scenario, request, follower, outcome);
    scenario.live_pairs.reset();
    if (!wall->has_pairs()) {
        throw InputError(text::located(socket.string(),
                                       "no application has sent a pair; use metabuffer-gl "
                                       "or metabuffer_host.h to connect one"));
    }
    pictures.finish();
    folder.write(kReportFile, report_json(outcome.report));
    folder.put_in_place();
    if (!record_directory_.empty()) write_scenario(scenario, record_directory_);
    if (!quiet_) {
        std::cerr << report_summary(outcome.report) << "results in " << folder.path().string() << std::endl;
    }
    const Judgement judgement = judge(outcome, scenario_.file(), strict_);
    std::cerr << judgement.text;
    return judgement.status;
}

}  // namespace metabuffer
