#include <algorithm>
#include <locale>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include "host/text.h"
#include "report/bottleneck.h"
#include "report/report.h"
#include "report/text_table.h"
#include "scenario/scenario.h"

namespace metabuffer {

namespace {

using text::counted;
using text::decimal;

// The machine may have thousands of composers and the terminal has 100 columns: beyond these counts the summary shows
// totals and the worst ones, and leaves the rest to report.json.
constexpr std::size_t kDisplaysAcross = 8;
constexpr std::size_t kRenderersDown = 16;
constexpr std::size_t kListedLines = 8;
constexpr std::size_t kNameCharacters = 16;

constexpr double kPercent = 100.0;

std::string shortened(const std::string& name) {
    if (screen_width(name) <= kNameCharacters) return name;
    const std::string ellipsis = "...";
    std::string result = name;
    while (screen_width(result) + ellipsis.size() > kNameCharacters) {
        while ((static_cast<unsigned char>(result.back()) & 0xC0U) == 0x80U && result.size() > 1) {
            result.pop_back();
        }
        result.pop_back();
    }
    return result + ellipsis;
}

/// A number with as many digits as it needs: "100", "33.33".
std::string plain(double value) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << value;
    return text.str();
}

/// Lines of a list that may be long: the first few, then how many more there are.
std::string listed(const std::vector<std::string>& lines) {
    std::string result;
    const std::size_t shown = std::min(lines.size(), kListedLines);
    for (std::size_t n = 0; n < shown; ++n) result += "  " + lines[n] + "\n";
    if (shown < lines.size()) {
        result += "  ... and " + std::to_string(lines.size() - shown) + " more in the report\n";
    }
    return result;
}

std::string machine(const RunReport& report) {
    return counted(static_cast<std::int64_t>(report.renderers.size()), "renderer") + ", " +
           counted(static_cast<std::int64_t>(report.displays.size()), "display");
}

/// Each rate with the clocks or frames that it is taken from.
std::string rate_lines(const RunReport& report) {
    const std::string indent(12, ' ');
    const auto hz = [](double rate) { return decimal(rate, 2); };
    const FrameRates rates = report.frame_rates();
    std::string text = "frame rate  ";
    if (!rates.composition_hz) {
        text += "none: a single frame has no interval\n";
    } else {
        const SlowestInterval& slowest = *rates.slowest_interval;
        const bool is_limit = *rates.composition_hz >= report.rate_limits->composition_hz();
        text += hz(*rates.composition_hz) + " frames/s composited, " +
                (is_limit ? "no more than displays, links and raster allow"
                          : "start of the first to start of the last") +
                "\n" + indent + hz(slowest.hz) + " at the slowest, " + counted(slowest.cycles, "clock") +
                " up to the start of frame " + std::to_string(slowest.frame) + "\n" + indent +
                (rates.display_hz
                     ? hz(*rates.display_hz) + " frames/s shown, each new picture once, second swap to last"
                     : std::string("none shown: two frames have one swap after the first")) +
                "\n";
    }
    if (!report.rate_limits) return text;
    const RateLimits& limits = *report.rate_limits;
    const bool one_link = limits.pairs_per_second.size() == 1;
    const std::int64_t refreshes = limits.refreshes_per_frame();
    return text + "limits      displays " + hz(limits.refresh_hz) + " Hz" +
           (refreshes == 1 ? "" : ", " + std::to_string(refreshes) + " a frame") + ", " +
           (one_link ? "link " : "slowest link ") + hz(limits.slowest_pairs_per_second()) +
           " pairs/s, raster " + hz(limits.raster_hz) + " frames/s\n";
}

/// What the run waited for most.
std::string bottleneck_line(const RunReport& report) {
    const std::optional<Bottleneck> found = find_bottleneck(report);
    if (!found) return "";
    const auto percent = [](double share) { return decimal(kPercent * share, 1) + " %"; };
    std::string text = std::string("bottleneck  ") + resource_name(found->what());
    if (found->starves) {
        return text + ": pixels starve; the bus of " + shortened(found->supply_renderer) + " works " +
               percent(found->bus_load) + " of the raster's clocks\n";
    }
    text += ": " + percent(found->share()) + " of the clocks from first pixel to last";
    for (std::size_t n = 0; n < kResourceCount; ++n) {
        const auto resource = static_cast<Resource>(n);
        constexpr double kLeastShown = 0.0005;
        const double share =
            static_cast<double>(found->cycles[n]) / static_cast<double>(found->total_cycles());
        if (resource == found->what() || share < kLeastShown) continue;
        text += std::string(", ") + resource_name(resource) + " " + percent(share);
    }
    return text + "\n";
}

/// What the machine needs, and whether its clock can be reached.
std::string cost_lines(const RunReport& report) {
    if (!report.cost) return "";
    const MachineCost& cost = *report.cost;
    const auto megabits = [](std::int64_t bits) { return decimal(static_cast<double>(bits) / 1e6, 2); };
    std::string text = "cost        " + decimal(cost.weighted(), 0) +
                       " by the usual weights: " + megabits(cost.buffer_bits) + " Mbit of FIFOs, " +
                       megabits(cost.input_framebuffer_bits + cost.output_framebuffer_bits) +
                       " of framebuffers, " + counted(cost.memory_devices, "memory device") + "\n";
    const bool arbiter_is_slower = cost.arbiter_mhz < cost.composer_mhz;
    const double reached_mhz = std::min(cost.arbiter_mhz, cost.composer_mhz);
    if (report.core_mhz > reached_mhz) {
        text +=
            "clock       " + plain(report.core_mhz) + " MHz asked for; in cells of 0.18 um, without wires, " +
            (arbiter_is_slower ? "an arbiter" : "a composer") + " reaches " + decimal(reached_mhz, 0) + "\n";
    }
    return text;
}

/// Pictures are as displays show them, so their colours are not those of the images.
std::string correction_line(const RunReport& report) {
    if (report.corrected_displays.empty()) return "";
    return "corrected   the colours of display " + text::number_runs(report.corrected_displays) +
           ", as their pictures show\n";
}

std::string timing_lines(const RunReport& report) {
    const std::string mhz = plain(report.core_mhz) + " MHz";
    std::string text = "frames      " + std::to_string(report.frames_shown()) + " shown on every display, " +
                       std::to_string(report.frames.size()) + " composited\n" + "clocks      " +
                       std::to_string(report.core_cycles) + " core clocks at " + mhz + "\n";
    if (report.frames.empty()) return text;

    text += rate_lines(report) + bottleneck_line(report);
    if (const std::string line = idle_bus_line(report.bus_width_bits, report.memory_words_per_cycle);
        !line.empty()) {
        text += "bus         " + line + "\n";
    }

    std::vector<std::int64_t> latencies;
    for (const FrameRecord& frame : report.frames) {
        if (frame.latency_cycles) latencies.push_back(*frame.latency_cycles);
    }
    if (latencies.empty()) return text + "latency     none: no frame showed a new pair\n";
    const auto [least, most] = std::minmax_element(latencies.begin(), latencies.end());
    const auto microseconds = [&report](std::int64_t cycles) {
        return decimal(static_cast<double>(cycles) / report.core_mhz, 2);
    };
    const bool alike = *least == *most;
    return text + "latency     " + std::to_string(*least) + (alike ? "" : " to " + std::to_string(*most)) +
           " clocks (" + microseconds(*least) + (alike ? "" : " to " + microseconds(*most)) +
           " us), last DVI pixel to last composited pixel\n";
}

std::vector<std::string> bus_cells(const std::string& name, const BusCounters& bus,
                                   const RendererCounters& renderer) {
    const std::int64_t wanted = bus.wanted_cycles();
    const double poll =
        wanted == 0 ? 0.0 : static_cast<double>(bus.poll_cycles) / static_cast<double>(wanted);
    return {name,
            decimal(kPercent * bus.utilization(), 1),
            decimal(kPercent * poll, 1),
            std::to_string(bus.pixels_sent),
            std::to_string(bus.page_misses),
            std::to_string(bus.recovered_slots),
            std::to_string(renderer.repeated_frames),
            std::to_string(renderer.dropped_frames),
            std::to_string(renderer.total_rejected())};
}

std::string bus_table(const RunReport& report) {
    TextTable table;
    table.add({"bus", "used %", "poll %", "pixels sent", "page misses", "recovered", "repeated", "dropped",
               "rejected"});
    for (const RendererCounters& renderer : report.renderers) {
        if (report.renderers.size() > kRenderersDown) continue;
        table.add(bus_cells(shortened(renderer.name), renderer.bus, renderer));
    }
    if (report.renderers.size() != 1) {
        table.add(bus_cells("all", report.total_bus(), report.total_renderer()));
    }

    std::string text = "\nbuses, in % of the clocks with something to send:\n" + table.text();
    if (report.renderers.size() > kRenderersDown) {
        const auto [least, most] =
            std::minmax_element(report.renderers.begin(), report.renderers.end(),
                                [](const RendererCounters& a, const RendererCounters& b) {
                                    return a.bus.utilization() < b.bus.utilization();
                                });
        text += "  used least: " + least->name + ", " + decimal(kPercent * least->bus.utilization(), 1) +
                " %; most: " + most->name + ", " + decimal(kPercent * most->bus.utilization(), 1) + " %\n";
    }
    return text;
}

std::string renderer_name(const RunReport& report, int renderer) {
    const auto index = static_cast<std::size_t>(renderer) - 1;
    return index < report.renderers.size() ? report.renderers[index].name
                                           : "renderer " + std::to_string(renderer);
}

std::string composer_name(const RunReport& report, const ComposerCounters& composer) {
    return renderer_name(report, composer.renderer) + " on display " + std::to_string(composer.display);
}

std::string high_water(const RunReport& report) {
    if (report.composers.empty()) return "";
    const std::string title = "\nbuffer high water of " + counted(report.buffer_pixels, "pixel");

    if (report.displays.size() > kDisplaysAcross || report.renderers.size() > kRenderersDown) {
        const auto fuller = [](const ComposerCounters& a, const ComposerCounters& b) {
            return a.buffer_high_water < b.buffer_high_water;
        };
        const auto most = std::max_element(report.composers.begin(), report.composers.end(), fuller);
        double sum = 0.0;
        for (const ComposerCounters& composer : report.composers) {
            sum += static_cast<double>(composer.buffer_high_water);
        }
        return title + ", over " + counted(static_cast<std::int64_t>(report.composers.size()), "composer") +
               ":\n  mean " + decimal(sum / static_cast<double>(report.composers.size()), 1) + ", highest " +
               std::to_string(most->buffer_high_water) + " (" + composer_name(report, *most) + ")\n";
    }

    std::map<std::pair<int, int>, std::int64_t> marks;
    for (const ComposerCounters& composer : report.composers) {
        marks[{composer.renderer, composer.display}] = composer.buffer_high_water;
    }
    const auto displays = static_cast<int>(report.displays.size());
    TextTable table;
    std::vector<std::string> header{"display"};
    for (int display = 1; display <= displays; ++display) header.push_back(std::to_string(display));
    table.add(std::move(header));
    for (int renderer = 1; renderer <= static_cast<int>(report.renderers.size()); ++renderer) {
        std::vector<std::string> cells{shortened(renderer_name(report, renderer))};
        for (int display = 1; display <= displays; ++display) {
            const auto mark = marks.find({renderer, display});
            cells.push_back(mark == marks.end() ? "-" : std::to_string(mark->second));
        }
        table.add(std::move(cells));
    }
    return title + ", by composer:\n" + table.text();
}

/// The composers that have a count at all, the worst first.
std::vector<const ComposerCounters*> worst_first(const RunReport& report,
                                                 std::int64_t ComposerCounters::*counter) {
    std::vector<const ComposerCounters*> result;
    for (const ComposerCounters& composer : report.composers) {
        if (composer.*counter != 0) result.push_back(&composer);
    }
    std::stable_sort(result.begin(), result.end(),
                     [counter](const ComposerCounters* a, const ComposerCounters* b) {
                         return a->*counter > b->*counter;
                     });
    return result;
}

std::string starved_list(const RunReport& report) {
    std::vector<std::string> lines;
    for (const ComposerCounters* composer : worst_first(report, &ComposerCounters::starved_pixels)) {
        std::string line =
            composer_name(report, *composer) + ": " + counted(composer->starved_pixels, "pixel");
        if (composer->first_glitch) {
            const StarvedPixel& pixel = *composer->first_glitch;
            line += ", first in frame " + std::to_string(pixel.frame) + " at x " + std::to_string(pixel.x) +
                    ", y " + std::to_string(pixel.y);
        }
        const auto kept = static_cast<std::int64_t>(composer->starved_runs.size());
        if (composer->starved_run_count > kept && kept > 0) {
            line += "; the report lists the first " + std::to_string(kept) + " of " +
                    std::to_string(composer->starved_run_count) + " runs, up to frame " +
                    std::to_string(composer->starved_runs.back().frame);
        }
        lines.push_back(std::move(line));
    }
    return lines.empty() ? "" : "\nstarved:\n" + listed(lines);
}

/// The frames that a display (index) showed wrong pixels of.
std::vector<int> wrong_frames(const RunReport& report, std::size_t display) {
    std::vector<int> frames;
    for (const FrameRecord& frame : report.frames) {
        if (frame.wrong_pixels && (*frame.wrong_pixels)[display] > 0) frames.push_back(frame.index);
    }
    return frames;
}

std::string in_frames(const std::vector<int>& frames) {
    constexpr std::size_t kMostCharacters = 60;
    const std::string runs = text::number_runs(frames);
    return std::string(frames.size() == 1 ? "in frame " : "in frames ") +
           (runs.size() <= kMostCharacters
                ? runs
                : std::to_string(frames.front()) + " to " + std::to_string(frames.back()) + ", " +
                      std::to_string(frames.size()) + " of them");
}

/// The pixels that displays show wrong because some starved or came wrong over a link.
std::string wrong_list(const RunReport& report) {
    const std::optional<std::int64_t> wrong = report.total_wrong_pixels();
    if (wrong.value_or(report.total_starved_pixels()) == 0) return "";
    if (!wrong) return "\nshown wrong: not known without pictures\n";
    std::vector<std::string> lines;
    for (std::size_t display = 0; display < report.displays.size(); ++display) {
        const std::int64_t pixels = *report.wrong_pixels_of_display(display);
        if (pixels == 0) continue;
        lines.push_back("display " + std::to_string(display + 1) + ": " + counted(pixels, "pixel") + " " +
                        in_frames(wrong_frames(report, display)));
    }
    return lines.empty() ? "" : "\nshown wrong:\n" + listed(lines);
}

std::string stalled_list(const RunReport& report) {
    std::vector<std::string> lines;
    for (const ComposerCounters* composer : worst_first(report, &ComposerCounters::stalled_cycles)) {
        lines.push_back(composer_name(report, *composer) + ": " + counted(composer->stalled_cycles, "clock"));
    }
    return lines.empty() ? "" : "\nstalled their column:\n" + listed(lines);
}

std::string rejected_lists(const RunReport& report) {
    std::vector<std::string> frames;
    std::vector<std::string> rows;
    for (const RendererCounters& renderer : report.renderers) {
        std::string causes;
        for (int cause = 0; cause < kRejectCauseCount; ++cause) {
            const std::int64_t count = renderer.rejected_frames[static_cast<std::size_t>(cause)];
            if (count == 0) continue;
            causes += (causes.empty() ? "" : ", ") +
                      std::string(reject_cause_key(static_cast<RejectCause>(cause))) + " " +
                      std::to_string(count);
        }
        if (!causes.empty()) frames.push_back(renderer.name + ": " + causes);

        for (const std::string& message : renderer.rejected_row_messages) {
            rows.push_back(renderer.name + ": " + message);
        }
        const std::int64_t untold =
            renderer.total_rejected_rows() - static_cast<std::int64_t>(renderer.rejected_row_messages.size());
        if (untold > 0) rows.push_back(renderer.name + ": " + counted(untold, "further row"));
    }
    return (frames.empty() ? "" : "\nrejected frames:\n" + listed(frames)) +
           (rows.empty() ? "" : "\nrejected table rows:\n" + listed(rows));
}

std::string starved_verdict(const RunReport& report) {
    const std::int64_t starved = report.total_starved_pixels();
    if (starved == 0) return "no pixel starved";

    std::vector<int> displays;
    for (const ComposerCounters& composer : report.composers) {
        if (composer.starved_pixels != 0) displays.push_back(composer.display);
    }
    std::sort(displays.begin(), displays.end());
    displays.erase(std::unique(displays.begin(), displays.end()), displays.end());

    std::string text =
        counted(starved, "pixel") + " starved on display" + (displays.size() == 1 ? " " : "s ");
    const std::size_t shown = std::min(displays.size(), kListedLines);
    for (std::size_t n = 0; n < shown; ++n) text += (n == 0 ? "" : ", ") + std::to_string(displays[n]);
    if (shown < displays.size()) text += " and " + std::to_string(displays.size() - shown) + " more";
    const std::optional<std::int64_t> wrong = report.total_wrong_pixels();
    return wrong ? text + ", " + counted(*wrong, "pixel") + " shown wrong" : text;
}

std::string stalled_verdict(const RunReport& report) {
    const std::int64_t clocks = report.total_display().stalled_cycles;
    return clocks == 0 ? "" : "columns stalled for " + counted(clocks, "clock");
}

std::string rejected_verdict(const RunReport& report) {
    const std::int64_t frames = report.total_rejected_frames();
    const std::int64_t rows = report.total_rejected_rows();
    const std::int64_t slot_tables = report.total_renderer().rejected_slot_tables;
    std::vector<std::string> rejected;
    if (frames != 0) rejected.push_back(counted(frames, "frame"));
    if (rows != 0) rejected.push_back(counted(rows, "table row"));
    if (slot_tables != 0) rejected.push_back(counted(slot_tables, "slot table"));
    return rejected.empty() ? "" : text::joined(rejected, "and") + " rejected";
}

std::string clamped_list(const RunReport& report) {
    std::vector<std::string> lines;
    for (const auto& [file, clamped] : report.clamped_depths) {
        const std::string before = counted(clamped.before_near_pixels, "pixel") + " before near";
        const std::string behind = counted(clamped.behind_far_pixels, "pixel") + " behind far";
        lines.push_back(
            text::one_line(file) + ": " + (clamped.before_near_pixels == 0 ? behind : before) +
            (clamped.before_near_pixels != 0 && clamped.behind_far_pixels != 0 ? ", " + behind : ""));
    }
    return lines.empty() ? "" : "\nclamped to depth_range:\n" + listed(lines);
}

/// What only a scenario with faults has to report.
std::string faults_verdict(const RunReport& report) {
    const std::int64_t faults = report.total_renderer().injected_faults;
    return faults == 0 ? "" : counted(faults, "fault") + " injected";
}

std::string lost_verdict(const RunReport& report) {
    const ComposerCounters composers = report.total_composer();
    std::string text;
    if (composers.lost_pixels != 0) text += counted(composers.lost_pixels, "pixel");
    if (composers.lost_tables != 0)
        text += (text.empty() ? "" : " and ") + counted(composers.lost_tables, "table");
    return text.empty() ? "" : text + " lost on the buses";
}

std::string kept_verdict(const RunReport& report) {
    std::int64_t frames = 0;  // each display keeps its picture, so the frame counts once
    for (const DisplayCounters& display : report.displays) frames = std::max(frames, display.kept_frames);
    return frames == 0 ? "" : counted(frames, "frame") + " replaced by the picture before";
}

std::string joined(const std::vector<std::string>& parts) {
    std::string text;
    for (const std::string& part : parts) {
        if (!part.empty()) text += (text.empty() ? "" : "; ") + part;
    }
    return text;
}

/// The functional level has no clock and so no buses, buffers or starvation to report.
std::string functional_summary(const RunReport& report) {
    const std::string rejected = rejected_verdict(report);
    return report.scenario + " (functional: " + machine(report) + ", no clock)\n" + "frames      " +
           std::to_string(report.frames_shown()) + " shown on every display\n" + correction_line(report) +
           rejected_lists(report) + clamped_list(report) + "\n" +
           (rejected.empty() ? "nothing rejected" : rejected) + "\n";
}

}  // namespace

std::string idle_bus_line(int width_bits, int words_per_cycle) {
    const int idle_bits = idle_bus_bits(width_bits, words_per_cycle);
    if (idle_bits == 0) return "";
    return std::to_string(width_bits) + " bits wide, of which memory fills " +
           std::to_string(width_bits - idle_bits) +
           ", 64 x memory.words_per_cycle; a bus of so many does the same";
}

std::string report_summary(const RunReport& report) {
    if (report.level == "functional") return functional_summary(report);
    return report.scenario + " (" + report.level + ": " + machine(report) + ")\n" + timing_lines(report) +
           cost_lines(report) + correction_line(report) + bus_table(report) + high_water(report) +
           starved_list(report) + wrong_list(report) + stalled_list(report) + rejected_lists(report) +
           clamped_list(report) + "\n" +
           joined({starved_verdict(report), stalled_verdict(report), rejected_verdict(report),
                   lost_verdict(report), kept_verdict(report), faults_verdict(report)}) +
           "\n";
}

}  // namespace metabuffer
