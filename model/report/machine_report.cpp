#include "report/machine_report.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "scenario/fault_keys.h"

namespace metabuffer {

std::int64_t raster_pixels_of_run(const Scenario& scenario) {
    return std::int64_t{scenario.displays.raster_width_pixels()} * scenario.displays.raster_height_pixels() *
           scenario.displays.count() * scenario.frames;
}

std::vector<ImageDepths> clamped_depths(const Scenario& scenario) {
    std::vector<ImageDepths> depths;
    std::set<const StoredImage*> known;
    for (const Renderer& renderer : scenario.renderers) {
        for (const auto& image : renderer.images) {
            if (!image->clamped().any() || !known.insert(image.get()).second) continue;
            const auto files = scenario.image_files.find(image.get());
            const bool is_known = files != scenario.image_files.end();
            depths.push_back({is_known ? files->second.depth.value_or(files->second.image).string() : "",
                              image->clamped()});
        }
    }
    return depths;
}

bool ShownFrames::add(std::size_t display, int frame) {
    last_[display] = frame;
    const int shown = *std::min_element(last_.begin(), last_.end()) + 1;
    if (shown <= on_all_displays_) {
        return false;
    }
    on_all_displays_ = shown;
    return true;
}

MachineReport::MachineReport(const Scenario& scenario, const std::string& level, const ShownFrames& shown,
                             std::int64_t core_cycles)
    : scenario_(scenario),
      shown_(shown),
      newest_pixel_picoseconds_(static_cast<std::size_t>(shown.on_all_displays())) {
    report_.scenario = scenario.name;
    report_.level = level;
    report_.core_mhz = scenario.clocks.core_mhz;
    report_.core_cycles = core_cycles;
    report_.rate_limits = rate_limits(scenario);
    report_.raster_pixels =
        std::int64_t{scenario.displays.raster_width_pixels()} * scenario.displays.raster_height_pixels();
    report_.cost = machine_cost(scenario);
    report_.is_reset = std::any_of(scenario.faults.begin(), scenario.faults.end(),
                                   [](const Fault& fault) { return fault.kind == FaultKind::kReset; });
    report_.memory_words_per_cycle = scenario.memory.words_per_cycle;
    report_.bus_width_bits = scenario.bus.width_bits;
    report_.corrected_displays = scenario.displays.corrected();
    report_.buffer_pixels = scenario.composer.buffer_pixels;
    report_.frames.resize(newest_pixel_picoseconds_.size());
    for (std::size_t f = 0; f < report_.frames.size(); ++f) {
        report_.frames[f].index = static_cast<int>(f);
        report_.frames[f].start_cycle = std::numeric_limits<std::int64_t>::max();
        report_.frames[f].starved_pixels.resize(static_cast<std::size_t>(scenario.displays.count()));
    }
}

void MachineReport::add_renderer(RendererCounters counters, const std::vector<FrameSource>& sources) {
    counters.name = scenario_.renderers[report_.renderers.size()].name;
    report_.renderers.push_back(std::move(counters));
    for (std::size_t f = 0; f < report_.frames.size(); ++f) {
        report_.frames[f].pairs.push_back(sources[f].pair);
        if (sources[f].fresh) {
            newest_pixel_picoseconds_[f] =
                std::max(newest_pixel_picoseconds_[f], std::optional(sources[f].last_pixel_picoseconds));
        }
    }
}

void MachineReport::add_composer(ComposerCounters counters) {
    const auto before = static_cast<int>(report_.composers.size());
    counters.renderer = before / scenario_.displays.count() + 1;
    counters.display = before % scenario_.displays.count() + 1;
    for (FrameRecord& frame : report_.frames) {
        frame.starved_pixels[static_cast<std::size_t>(counters.display) - 1] +=
            counters.starved_pixels_of(frame.index);
    }
    report_.composers.push_back(std::move(counters));
}

void MachineReport::add_display(DisplayCounters counters) {
    counters.frames_shown = shown_.last(report_.displays.size()) + 1;
    report_.displays.push_back(counters);
}

void MachineReport::add_composition(int frame, std::int64_t first_cycle, std::int64_t last_cycle) {
    FrameRecord& record = report_.frames[static_cast<std::size_t>(frame)];
    record.start_cycle = std::min(record.start_cycle, first_cycle);
    record.end_cycle = std::max(record.end_cycle, last_cycle);
}

void MachineReport::add_swap(int frame, const Swap& swap) {
    FrameRecord& record = report_.frames[static_cast<std::size_t>(frame)];
    record.swap_cycle = swap.picoseconds / clock_period_picoseconds(scenario_.clocks.core_mhz);
    record.kept = swap.kept;
}

RunReport MachineReport::finish(std::vector<std::string> watchdog_findings) {
    report_.clamped_depths = clamped_depths(scenario_);
    const std::int64_t period = clock_period_picoseconds(scenario_.clocks.core_mhz);
    for (std::size_t f = 0; f < report_.frames.size(); ++f) {
        if (const std::optional<std::int64_t> newest = newest_pixel_picoseconds_[f]) {
            report_.frames[f].latency_cycles = report_.frames[f].end_cycle - *newest / period;
        }
    }
    const bool links_err = disturbs_characters(scenario_);
    for (FrameRecord& frame : report_.frames) {
        const bool starved = std::any_of(frame.starved_pixels.begin(), frame.starved_pixels.end(),
                                         [](std::int64_t pixels) { return pixels > 0; });
        if (!starved && !links_err)
            frame.wrong_pixels = std::vector<std::int64_t>(frame.starved_pixels.size(), 0);
    }
    report_.watchdog = std::move(watchdog_findings);
    return std::move(report_);
}

}  // namespace metabuffer
