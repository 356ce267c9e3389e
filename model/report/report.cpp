#include "report/report.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include "report/counters.h"

namespace metabuffer {

const char* reject_cause_key(RejectCause cause) {
    switch (cause) {
        case RejectCause::kGeometry:
            return "geometry";
        case RejectCause::kMagic:
            return "magic";
        case RejectCause::kVersion:
            return "version";
        case RejectCause::kKind:
            return "kind";
        case RejectCause::kCrc:
            return "crc";
        case RejectCause::kPair:
            return "pair";
    }
    return "unknown";
}

std::int64_t BusCounters::wanted_cycles() const {
    return busy_cycles + table_cycles + page_miss_cycles + refresh_cycles + write_cycles + grant_cycles +
           poll_cycles + lost_cycles;
}

double BusCounters::utilization() const {
    const std::int64_t wanted = wanted_cycles();
    return wanted == 0 ? 0.0 : static_cast<double>(busy_cycles) / static_cast<double>(wanted);
}

std::int64_t RendererCounters::total_rejected_frames() const {
    return std::accumulate(rejected_frames.begin(), rejected_frames.end(), std::int64_t{0});
}

std::int64_t RendererCounters::total_rejected_rows() const {
    return std::accumulate(rejected_rows.begin(), rejected_rows.end(), std::int64_t{0});
}

std::int64_t RendererCounters::total_rejected() const {
    return total_rejected_frames() + total_rejected_rows() + rejected_slot_tables;
}

void RendererCounters::add_rejected_rows(std::uint32_t pair, const ValidatedTable& table) {
    for (const RejectedRow& row : table.rejected) {
        ++rejected_rows[static_cast<std::size_t>(row.defect)];
        if (rejected_row_messages.size() < kRowMessagesKept) {
            rejected_row_messages.push_back("pair " + std::to_string(pair) + ", row " +
                                            std::to_string(row.index) + ": " + row.message);
        }
    }
}

void ComposerCounters::add_starved_pixel(const StarvedPixel& pixel) {
    if (starved_pixels == 0) first_glitch = pixel;
    add_starved_pixels(pixel.frame, 1);
    const bool goes_on = last_glitch && last_glitch->frame == pixel.frame && last_glitch->y == pixel.y &&
                         last_glitch->x + 1 == pixel.x;
    last_glitch = pixel;
    if (!goes_on) {
        ++starved_run_count;
        if (starved_run_count <= kStarvedRunsKept) {
            starved_runs.push_back({pixel.frame, pixel.y, pixel.x, pixel.x});
        }
    } else if (starved_run_count <= kStarvedRunsKept) {
        starved_runs.back().x_last = pixel.x;
    }
}

void ComposerCounters::add_starved_pixels(int frame, std::int64_t pixels) {
    starved_pixels += pixels;
    const auto f = static_cast<std::size_t>(frame);
    if (f >= starved_by_frame.size()) starved_by_frame.resize(f + 1);
    starved_by_frame[f] += pixels;
}

void ComposerCounters::add_starved_run(const StarvedRun& run) {
    add_starved_pixels(run.frame, run.x_last - run.x_first + 1);
    if (!first_glitch) first_glitch = StarvedPixel{run.frame, run.x_first, run.y};
    last_glitch = StarvedPixel{run.frame, run.x_last, run.y};
    ++starved_run_count;
    if (starved_run_count <= kStarvedRunsKept) starved_runs.push_back(run);
}

BusCounters RunReport::total_bus() const {
    BusCounters total;
    for (const RendererCounters& renderer : renderers) add_counters(total, renderer.bus);
    return total;
}

RendererCounters RunReport::total_renderer() const {
    RendererCounters total;
    const auto add = [](auto& sums, const auto& counts) {
        std::transform(sums.begin(), sums.end(), counts.begin(), sums.begin(), std::plus<>());
    };
    for (const RendererCounters& renderer : renderers) {
        add_counters(total, renderer);
        add(total.rejected_frames, renderer.rejected_frames);
        add(total.rejected_rows, renderer.rejected_rows);
    }
    return total;
}

ComposerCounters RunReport::total_composer() const {
    ComposerCounters total;
    for (const ComposerCounters& composer : composers) add_counters(total, composer);
    return total;
}

DisplayCounters RunReport::total_display() const {
    DisplayCounters total;
    for (const DisplayCounters& display : displays) add_counters(total, display);
    return total;
}

std::optional<std::int64_t> RunReport::wrong_pixels_of_display(std::size_t display) const {
    std::int64_t sum = 0;
    for (const FrameRecord& frame : frames) {
        if (!frame.wrong_pixels) return std::nullopt;
        sum += (*frame.wrong_pixels)[display];
    }
    return sum;
}

std::int64_t RunReport::starved_pixels_of_display(std::size_t display) const {
    std::int64_t sum = 0;
    for (const ComposerCounters& composer : composers) {
        if (static_cast<std::size_t>(composer.display) == display + 1) sum += composer.starved_pixels;
    }
    return sum;
}

std::optional<std::int64_t> RunReport::total_wrong_pixels() const {
    std::int64_t sum = 0;
    for (std::size_t display = 0; display < displays.size(); ++display) {
        const std::optional<std::int64_t> pixels = wrong_pixels_of_display(display);
        if (!pixels) return std::nullopt;
        sum += *pixels;
    }
    return sum;
}

std::int64_t RunReport::frames_shown() const {
    if (displays.empty()) return 0;
    return std::min_element(displays.begin(), displays.end(),
                            [](const DisplayCounters& a, const DisplayCounters& b) {
                                return a.frames_shown < b.frames_shown;
                            })
        ->frames_shown;
}

std::int64_t RunReport::composition_cycles() const {
    // Both ends count: the last pixel is composited in the clock end_cycle.
    return frames.empty() ? 0 : frames.back().end_cycle - frames.front().start_cycle + 1;
}

std::optional<double> FrameRates::held_hz() const {
    if (!composition_hz || !slowest_interval || !display_hz) return std::nullopt;
    return std::min({*composition_hz, slowest_interval->hz, *display_hz});
}

namespace {

/// most_hz: frames a second that can be composited.
SlowestInterval slowest_interval(const std::vector<FrameRecord>& frames, double core_hz, double most_hz) {
    SlowestInterval slowest;
    for (std::size_t f = 1; f < frames.size(); ++f) {
        const std::int64_t cycles = frames[f].start_cycle - frames[f - 1].start_cycle;
        if (cycles > slowest.cycles)
            slowest = {cycles, frames[f].index, std::min(most_hz, core_hz / static_cast<double>(cycles))};
    }
    return slowest;
}

/// Frames from the third on that the displays switched to and that show other pairs than the picture before.
std::int64_t different_frames_shown(const std::vector<FrameRecord>& frames) {
    std::int64_t count = 0;
    const FrameRecord* shown = nullptr;
    for (std::size_t f = 0; f < frames.size(); ++f) {
        if (frames[f].kept) continue;
        const bool is_new = shown == nullptr || frames[f].pairs != shown->pairs;
        if (is_new && f >= 2) ++count;
        shown = &frames[f];
    }
    return count;
}

}  // namespace

FrameRates RunReport::frame_rates() const {
    FrameRates rates;
    if (!rate_limits || frames.size() < 2) return rates;
    const auto per_second = [core_hz = rate_limits->core_hz](std::int64_t count, std::int64_t cycles) {
        return core_hz * static_cast<double>(count) / static_cast<double>(cycles);
    };
    const auto intervals = static_cast<std::int64_t>(frames.size()) - 1;
    rates.composition_hz =
        std::min(rate_limits->composition_hz(),
                 per_second(intervals, frames.back().start_cycle - frames.front().start_cycle));
    rates.slowest_interval = slowest_interval(frames, rate_limits->core_hz, rate_limits->composition_hz());
    if (intervals >= 2) {
        rates.display_hz = std::min(
            rate_limits->different_hz(),
            per_second(different_frames_shown(frames), frames.back().swap_cycle - frames[1].swap_cycle));
    }
    return rates;
}

}  // namespace metabuffer
