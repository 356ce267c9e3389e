#include "tools/program/starvation_advice.h"

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <optional>
#include <sstream>
#include <tuple>

#include "host/errors.h"
#include "host/text.h"
#include "scenario/limits.h"
#include "scenario/scenario_loader.h"
#include "tlm/run.h"
#include "tools/analysis/bandwidth_analysis.h"
#include "tools/program/level_run.h"

namespace metabuffer {
namespace {

/// How a run of a changed scenario ended.
struct Outcome {
    bool is_clean = false;  ///< nothing starved, and the watchdog did not end it
    std::int64_t rejected = 0;
    double frames_per_second = 0.0;
};

Outcome outcome_of(const Scenario& scenario) {
    tlm::RunOptions options;
    options.images = false;
    const RunReport report = tlm::run(scenario, options).report;
    Outcome outcome;
    outcome.is_clean = report.total_starved_pixels() == 0 && report.watchdog.empty();
    outcome.rejected = report.total_rejected();
    outcome.frames_per_second = report.frame_rates().composition_hz.value_or(0.0);
    return outcome;
}

/// Tries changes of a scenario, each in a process of its own, until its time is over.
class Trials {
  public:
    Trials(const Scenario& scenario, std::int64_t rejected) : scenario_(scenario), rejected_(rejected) {}

    std::string lines() const {
        // The search for the buffer takes as long as all others together.
        ChildProcess of_buffer([this](const ChildProcess::Sender& sender) { send(sender, buffer()); });
        ChildProcess others([this](const ChildProcess::Sender& sender) {
            send(sender, stall());
            send(sender, bus_and_memory());
        });
        const Clock::time_point end = end_ + std::chrono::milliseconds(kSendingMilliseconds);
        const std::string lines = received(of_buffer, end);
        return lines + received(others, end);
    }

  private:
    using Clock = std::chrono::steady_clock;
    /// For a process to send what it knows when its time is over.
    static constexpr int kSendingMilliseconds = 50;

    static void send(const ChildProcess::Sender& sender, const std::string& line) {
        sender.send(line.data(), line.size());
    }

    /// Nothing if the time is over, or the change makes no valid scenario or does not help.
    std::optional<Outcome> tried(const Scenario& changed) const {
        if (is_time_over()) return std::nullopt;
        try {
            check_scenario(changed);
            ChildProcess process([&changed](const ChildProcess::Sender& sender) {
                const Outcome outcome = outcome_of(changed);
                sender.send(&outcome, sizeof outcome);
            });
            const std::string bytes = received(process, end_);
            Outcome outcome;
            if (bytes.size() != sizeof outcome) return std::nullopt;
            std::memcpy(&outcome, bytes.data(), sizeof outcome);
            const bool rejects_more = outcome.rejected * scenario_.frames > rejected_ * changed.frames;
            if (!outcome.is_clean || rejects_more) return std::nullopt;
            return outcome;
        } catch (const InputError&) {
            return std::nullopt;
        }
    }
    /// What the process sends until it ends or the time is over.
    static std::string received(ChildProcess& process, Clock::time_point end) {
        std::string bytes;
        while (!process.ended()) {
            const auto left =
                std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
            pollfd wanted{process.descriptor(), POLLIN, 0};
            if (poll(&wanted, 1, static_cast<int>(std::max<std::int64_t>(left, 0))) <= 0) break;
            process.receive(bytes);
        }
        return bytes;
    }
    bool is_time_over() const { return Clock::now() >= end_; }

    std::string stall() const {
        Scenario changed = scenario_;
        changed.composer.on_starvation = StarvationMode::kStall;
        changed.frames = std::max(changed.frames, kFramesForRates);  // a single frame has no rate
        const std::optional<Outcome> outcome = tried(changed);
        if (!outcome) return "";
        return "composer.on_starvation: stall, at " + text::decimal(outcome->frames_per_second, 2) +
               " frames/s\n";
    }

    /// The narrowest of the wider ones that is enough, with longer bursts if need be, since each burst may miss a page. Bus
    /// and memory limit each other, so both grow. A width whose longest bursts are not enough is not looked at further.
    std::string bus_and_memory() const {
        std::vector<int> bursts{1};  // times as long as they are
        while (bursts.back() < 8 &&
               bursts.back() * 8 * scenario_.bus.burst_pixels <= scenario_.composer.buffer_pixels) {
            bursts.push_back(bursts.back() * 2);
        }
        for (const int width_bits : limits::kBusWidthsBits) {
            if (width_bits < scenario_.bus.width_bits || !is_enough(width_bits, bursts.back())) continue;
            const auto shortest = std::find_if(bursts.begin(), bursts.end() - 1,
                                               [&](int times) { return is_enough(width_bits, times); });
            return difference_of(widened(width_bits, *shortest)) + "\n";
        }
        return "";
    }
    bool is_enough(int width_bits, int times) const {
        const Scenario changed = widened(width_bits, times);
        return !difference_of(changed).empty() && tried(changed);
    }

    Scenario widened(int width_bits, int times) const {
        Scenario changed = scenario_;
        BusConfig& bus = changed.bus;
        MemoryConfig& memory = changed.memory;
        bus.width_bits = width_bits;
        memory.words_per_cycle = std::max(memory.words_per_cycle, width_bits / kPixelBits);
        bus.burst_pixels *= times;
        if (scenario_.composer.ready_space_pixels ==
            default_ready_space_pixels(scenario_.bus, scenario_.memory)) {
            changed.composer.ready_space_pixels = default_ready_space_pixels(bus, memory);
        }
        return changed;
    }

    std::string difference_of(const Scenario& changed) const {
        const auto& [bus, memory] = std::tie(changed.bus, changed.memory);
        std::vector<std::string> keys;
        if (bus.width_bits != scenario_.bus.width_bits) {
            keys.push_back("bus.width_bits: " + std::to_string(bus.width_bits));
        }
        if (memory.words_per_cycle != scenario_.memory.words_per_cycle) {
            keys.push_back("memory.words_per_cycle: " + std::to_string(memory.words_per_cycle));
        }
        if (bus.burst_pixels != scenario_.bus.burst_pixels) {
            keys.push_back("bus.burst_pixels: " + std::to_string(bus.burst_pixels));
        }
        return text::joined(keys, "and");
    }

    /// By halves between the scenario's own buffer, which is too small, and one that holds all that is ever needed.
    std::string buffer() const {
        const analysis::Analysis analysis = analysis::analyze(scenario_);
        std::int64_t too_small =
            std::max<std::int64_t>(scenario_.composer.buffer_pixels, analysis.least_buffer_pixels - 1);
        std::int64_t enough = analysis.whole_buffer_pixels;
        if (analysis.safe_buffer_is_legal.value_or(false))
            enough = std::min(enough, *analysis.safe_buffer_pixels);
        const auto is_good = [this](std::int64_t pixels) {
            Scenario changed = scenario_;
            changed.composer.buffer_pixels = static_cast<int>(pixels);
            return tried(changed).has_value();
        };
        if (enough <= too_small || !is_good(enough)) return "";
        while (enough - too_small > 1) {
            const std::int64_t middle = too_small + (enough - too_small) / 2;
            const bool is_middle_good = is_good(middle);
            if (is_time_over()) return "composer.buffer_pixels: " + std::to_string(enough) + " or less\n";
            (is_middle_good ? enough : too_small) = middle;
        }
        return "composer.buffer_pixels: " + std::to_string(enough) + "\n";
    }

    const Scenario& scenario_;
    std::int64_t rejected_;
    Clock::time_point end_ = Clock::now() + std::chrono::milliseconds(StarvationAdvice::kMostMilliseconds);
};

}  // namespace

/// It waits until the run has ended, and tries changes then if pixels have starved.
class StarvationAdvice::Process {
  public:
    explicit Process(const Scenario& scenario)
        : process_([this, &scenario](const ChildProcess::Sender& pipe) {
              channel_.be_child();
              close_descriptors_but({channel_.descriptor(), pipe.descriptor()});
              be_silent();
              const std::string rejected = channel_.receive();
              if (!rejected.empty()) channel_.send(Trials(scenario, std::stoll(rejected)).lines());
          }) {
        channel_.be_parent();
    }

    std::string lines(std::int64_t rejected) const {
        return channel_.send(std::to_string(rejected)) ? channel_.receive() : "";
    }

  private:
    MessageChannel channel_;
    ChildProcess process_;
};

StarvationAdvice::StarvationAdvice(const Scenario& scenario) {
    if (scenario.composer.may_stall() || !level_tlm_knows_clocks(scenario)) return;
    try {
        process_ = std::make_unique<Process>(scenario);
    } catch (const InputError&) {
        // This computer has no process left: there is no advice.
    }
}

StarvationAdvice::~StarvationAdvice() = default;

std::vector<std::string> StarvationAdvice::lines(const RunReport& report) const {
    std::vector<std::string> lines;
    if (process_ == nullptr || report.total_starved_pixels() == 0 || !report.watchdog.empty()) return lines;
    std::istringstream text(process_->lines(report.total_rejected()));
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
}

std::string StarvationAdvice::text(const RunReport& report, const std::string& scenario_file) const {
    if (report.total_starved_pixels() == 0) return "";
    const std::vector<std::string> lines = this->lines(report);
    if (lines.empty()) {
        return "what would do: metabuffer size " + scenario_file + " --minimize composer.buffer_pixels\n";
    }
    std::string text = "what would do, each by itself, as runs have shown:\n";
    for (const std::string& line : lines) text += "  " + line + "\n";
    return text;
}

}  // namespace metabuffer
