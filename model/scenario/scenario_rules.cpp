#include "scenario/scenario_rules.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "formats/slot_payload.h"
#include "host/errors.h"
#include "host/text.h"
#include "scenario/derived_timing.h"
#include "scenario/fault_keys.h"
#include "scenario/fault_kinds.h"
#include "scenario/limits.h"
#include "scenario/names.h"
#include "scenario/scenario_keys.h"
#include "scenario/scenario_loader.h"

namespace metabuffer {
namespace {

/// Collects the first violation; the checks after it do nothing.
class RuleCheck {
  public:
    void require(bool holds, const std::string& path, const std::string& message) {
        if (!holds && !violation_.has_value()) violation_ = RuleViolation{path, message};
    }
    void integer(const std::string& path, std::int64_t value, const IntegerRange& allowed) {
        if (!allowed.contains(value)) require(false, path, text::out_of_range(value, allowed));
    }
    /// The rule of the key itself.
    template <typename Object>
    void key(const std::string& path, const ObjectKey<Object>& key, const ValueRule& rule,
             const Object& object) {
        const std::optional<KeyValue> value = key.value(object);
        if (!value.has_value() || key.schema.length > 0) return;  // a list's numbers have rules of their own
        if (const std::string complaint = rule.complaint(*value); !complaint.empty()) {
            require(false, path, complaint);
        }
    }

    /// Whether a rule is broken, so that what follows from its values need not be computed.
    bool failed() const { return violation_.has_value(); }
    std::optional<RuleViolation> result() && { return std::move(violation_); }

  private:
    std::optional<RuleViolation> violation_;
};

void check_keys(RuleCheck& check, const Scenario& scenario) {
    for (const ObjectKey<Scenario>& key : setting_rows()) {
        if (key.value != nullptr) check.key(key.schema.pattern, key, key.schema.rule, scenario);
    }
}

/// A message names clocks and rates to the thousandth, on the side that is accepted.
constexpr double kThousandths = 1000.0;
double rounded_down(double number) { return std::floor(number * kThousandths) / kThousandths; }
double rounded_up(double number) { return std::ceil(number * kThousandths) / kThousandths; }

/// A clock that a refresh rate gives: its MHz may be given too if they agree.
void check_refresh_rate(RuleCheck& check, const std::string& clock, double refresh_hz, const DviTiming& mode,
                        double mhz) {
    constexpr double kRounding = 1e-9;
    const double needed_mhz = mhz_of_refresh(refresh_hz, mode);
    const std::string path = "clocks." + clock;
    const ValueRule& rule = scenario_schema().find(path + "_mhz")->rule;
    const double rate_of_mhz = 1.0 / mhz_of_refresh(1.0, mode);
    check.require(rule.complaint(needed_mhz).empty(), path + "_refresh_hz",
                  text::number(refresh_hz) + " frames of " + std::to_string(mode.frame_clocks()) +
                      " clocks need " + text::number(needed_mhz) + " MHz; use " +
                      text::range(NumberRange{rounded_up(rule.number.low * rate_of_mhz),
                                              rounded_down(rule.number.high * rate_of_mhz)}));
    check.require(std::abs(mhz - needed_mhz) <= kRounding * needed_mhz, path + "_mhz",
                  text::number(mhz) + " is not what " + clock + "_refresh_hz needs, " +
                      text::number(needed_mhz) + "; use one of the two");
}

/// All links have the same clock, so with a refresh rate their modes must have equally long frames.
void check_link_refresh_rate(RuleCheck& check, const Scenario& scenario) {
    const std::optional<double>& refresh_hz = scenario.clocks.given_dvi_in_refresh_hz;
    if (!refresh_hz || check.failed()) return;
    const DviTiming first = scenario.renderers.front().timing();
    double enough_mhz = 0.0;
    for (const Renderer& renderer : scenario.renderers) {
        enough_mhz = std::max(enough_mhz, rounded_up(mhz_of_refresh(*refresh_hz, renderer.timing())));
    }
    const bool is_clock = scenario_schema().find("clocks.dvi_in_mhz")->rule.complaint(enough_mhz).empty();
    for (const Renderer& renderer : scenario.renderers) {
        const DviTiming mode = renderer.timing();
        check.require(mode.frame_clocks() == first.frame_clocks(), "clocks.dvi_in_refresh_hz",
                      "needs images of one size, and " + text::quoted(renderer.name) + " and " +
                          text::quoted(scenario.renderers.front().name) + " differ; use dvi_in_mhz" +
                          (is_clock ? ": " + text::number(enough_mhz) + ", with which each link has " +
                                          text::number(*refresh_hz) + " frames a second or more"
                                    : ""));
    }
    check_refresh_rate(check, "dvi_in", *refresh_hz, first, scenario.clocks.dvi_in_mhz);
}

/// Between two refreshes the bus must be able to go on.
void check_refresh(RuleCheck& check, const MemoryConfig& memory) {
    const std::int64_t interval = memory.refresh_interval_cycles;
    if (!memory.refreshes()) {
        check.require(interval == 0, "memory.refresh_interval_cycles",
                      std::to_string(interval) + " without refresh_cycles; use both, or neither");
        return;
    }
    const std::int64_t least = least_refresh_interval_cycles(memory);
    check.require(interval > 0, "memory.refresh_cycles",
                  std::to_string(memory.refresh_cycles) + " without refresh_interval_cycles; use one of " +
                      std::to_string(least) + " or more, or neither");
    check.require(interval >= least, "memory.refresh_interval_cycles",
                  std::to_string(interval) + " leaves no cycle for a beat besides refresh_cycles" +
                      (memory.shared() ? ", page_miss_cycles and two blocks of the link's words"
                                       : " and page_miss_cycles") +
                      "; use " + std::to_string(least) + " or more");
}

/// With shared ports: the nearest clocks with which the link's words are written in time.
std::vector<std::string> clocks_for_writing(const Scenario& scenario) {
    std::vector<std::string> clocks;
    const auto add = [&clocks](const std::string& key, double value, const char* side) {
        const ValueRule& rule = scenario_schema().find("clocks." + key)->rule;
        if (rule.complaint(value).empty()) clocks.push_back(key + " " + text::number(value) + side);
    };
    constexpr double kPicoseconds = 1.0e6;  // of a MHz's period
    // Periods are rounded to whole picoseconds.
    const double above_mhz =
        kPicoseconds / (static_cast<double>(longest_core_period_picoseconds(scenario)) + 0.5);
    add("core_mhz", (std::floor(above_mhz * kThousandths) + 1.0) / kThousandths, " or more");
    const double link_mhz =
        kPicoseconds / (static_cast<double>(shortest_dvi_in_period_picoseconds(scenario)) - 0.5);
    if (scenario.clocks.given_dvi_in_refresh_hz) {
        const DviTiming mode = scenario.renderers.front().timing();
        add("dvi_in_refresh_hz", rounded_down(link_mhz / mhz_of_refresh(1.0, mode)), " or less");
    } else {
        add("dvi_in_mhz", rounded_down(link_mhz), " or less");
    }
    return clocks;
}

/// With shared ports each block of the link's words must be written before the next one is there, so that none is lost.
/// A pair's last blocks must be written before its verdict, so that none is read too early. This must hold however fast
/// a fault makes the link.
void check_write_blocks(RuleCheck& check, const Scenario& scenario, std::size_t index,
                        const std::string& path) {
    const MemoryConfig& memory = scenario.memory;
    if (!memory.shared() || check.failed()) return;
    const Renderer& renderer = scenario.renderers[index];
    const std::int64_t core_period = clock_period_picoseconds(scenario.clocks.core_mhz);
    const std::int64_t link_period = shortest_link_period_picoseconds(scenario, index);
    const bool drifts = link_period < clock_period_picoseconds(scenario.clocks.dvi_in_mhz);
    const std::string of_link = path + (drifts ? ", with the drift of its link," : "");
    const int words = memory.write_block_words;
    const std::int64_t comes = words * link_period / core_period;
    const int least = least_block_cycles(memory);
    const std::int64_t ends = longest_last_write_cycles(memory, renderer.image_words());
    const std::int64_t verdict = verdict_link_clocks(renderer) * link_period / core_period;
    if (comes >= least && verdict >= ends) return;
    std::vector<std::string> remedies = clocks_for_writing(scenario);
    remedies.emplace_back("more words_per_cycle");
    remedies.emplace_back(comes < least ? "larger blocks" : "smaller blocks");
    const std::string use = "; use " + text::joined(remedies, "or");
    check.require(comes >= least, "memory.write_block_words",
                  std::to_string(words) + " words of " + of_link + " come in " + std::to_string(comes) +
                      " core cycles, and until they are written and the bus has its page open again " +
                      std::to_string(least) + " may pass" + use);
    check.require(verdict >= ends, "memory.write_block_words",
                  std::to_string(words) + " words may be written as late as " + std::to_string(ends) +
                      " core cycles after the last pixel of " + of_link + " whose pair is judged after " +
                      std::to_string(verdict) + use);
}

/// The rules between keys.
void check_machine(RuleCheck& check, const Scenario& scenario) {
    if (check.failed()) return;
    const ValueRule& depth = scenario_schema().find("depth_range[]")->rule;
    const ImageReading& reading = scenario.image_reading;
    for (const double end : {reading.near, reading.far}) {
        const std::string complaint = depth.complaint(end);
        check.require(complaint.empty(), "depth_range", complaint);
    }
    check.require(reading.near != reading.far, "depth_range", same_depths(reading.near));
    const MemoryConfig& memory = scenario.memory;
    check.require(memory.precharge_cycles <= memory.page_miss_cycles, "memory.precharge_cycles",
                  std::to_string(memory.precharge_cycles) + " is more than page_miss_cycles, " +
                      std::to_string(memory.page_miss_cycles) + ", which counts it; use " +
                      std::to_string(memory.page_miss_cycles) + " or less");
    if (memory.given_activate_cycles) {
        const int sum = memory.precharge_cycles + *memory.given_activate_cycles;
        check.require(
            sum == memory.page_miss_cycles, "memory.page_miss_cycles",
            std::to_string(memory.page_miss_cycles) + " is not precharge_cycles + activate_cycles, " +
                std::to_string(memory.precharge_cycles) + " + " +
                std::to_string(*memory.given_activate_cycles) + "; use " + std::to_string(sum) +
                ", or activate_cycles: " + std::to_string(memory.page_miss_cycles - memory.precharge_cycles));
    }
    if (memory.shared()) {
        int divisor = std::min(memory.write_block_words, memory.page_words);
        while (memory.page_words % divisor != 0) --divisor;
        check.require(divisor == memory.write_block_words, "memory.write_block_words",
                      std::to_string(memory.write_block_words) + " does not divide page_words, " +
                          std::to_string(memory.page_words) + "; use " + std::to_string(divisor) +
                          " or another divisor of it");
    }
    check_refresh(check, memory);
    const int in_flight = in_flight_pixels(scenario.bus, scenario.memory);
    check.require(scenario.composer.ready_space_pixels >= in_flight, "composer.ready_space_pixels",
                  std::to_string(scenario.composer.ready_space_pixels) + " is less than the " +
                      std::to_string(in_flight) + " pixels that can be in flight; use " +
                      std::to_string(in_flight) + " or more");
}

/// Each display has one correction at most: by gains and gamma, or by a table.
void check_corrections(RuleCheck& check, const DisplayConfig& displays) {
    const ValueRule& gain_rule = scenario_schema().find("displays.correction[].gain[]")->rule;
    const DisplayCorrection untouched;
    std::set<int> corrected;
    for (std::size_t i = 0; i < displays.correction.size(); ++i) {
        const DisplayCorrection& correction = displays.correction[i];
        const std::string path = "displays.correction[" + std::to_string(i) + "]";
        check.require(correction.display >= 1 && correction.display <= displays.count(), path + ".display",
                      std::to_string(correction.display) + " is not a display; use 1 to " +
                          std::to_string(displays.count()));
        check.require(corrected.insert(correction.display).second, path + ".display",
                      std::to_string(correction.display) + " has a correction already; use one a display");
        for (const ObjectKey<DisplayCorrection>& key : correction_rows()) {
            if (key.value == nullptr) continue;
            const std::string name = key.schema.pattern;
            const std::string key_path = path + name.substr(name.rfind('.'));
            check.key(key_path, key, key.schema.rule, correction);
            check.require(
                !correction.has_lut() || key.required || key.value(correction) == key.value(untouched),
                key_path, "is given together with a lut; use one of the two");
        }
        for (const double gain : correction.gain) {
            const std::string complaint = gain_rule.complaint(gain);
            check.require(complaint.empty(), path + ".gain", complaint);
        }
    }
}

void check_names(RuleCheck& check, const Scenario& scenario) {
    if (check.failed()) return;
    const auto renderers = static_cast<std::int64_t>(scenario.renderers.size());
    check.require(renderers > 0, "renderers", "has no entries; use at least one renderer");
    const std::int64_t displays = scenario.displays.count();
    check.require(displays * renderers <= limits::kComposers, "renderers",
                  std::to_string(renderers) + " renderers on " + std::to_string(displays) +
                      " displays need " + std::to_string(displays * renderers) + " composers; use at most " +
                      std::to_string(limits::kComposers) + ", which is " +
                      std::to_string(limits::kComposers / displays) + " renderers");
    // The scenario's name is that of its results' folder.
    const bool plain_name =
        scenario.name.find('/') == std::string::npos && scenario.name != "." && scenario.name != "..";
    check.require(plain_name, "name",
                  text::quoted(scenario.name) + " is a path; use a plain name, without slashes");
    std::set<std::string> names;
    for (std::size_t i = 0; i < scenario.renderers.size(); ++i) {
        const std::string path = "renderers[" + std::to_string(i) + "]";
        const Renderer& renderer = scenario.renderers[i];
        check.require(!renderer.name.empty(), path + ".name", "is empty; use a name");
        check.require(
            names.insert(renderer.name).second, path + ".name",
            text::quoted(renderer.name) + " is taken by an earlier renderer; use a name of its own");
        check.require(!renderer.frames.empty(), path + ".frames", "has no entries; use at least one frame");
    }
}

std::string fault_path(std::size_t index) { return "faults[" + std::to_string(index) + "]"; }

/// The keys that go with its kind are in range, the others have their defaults.
void check_fault_keys(RuleCheck& check, const Fault& fault, const std::string& path) {
    const Fault untouched;
    for (const FaultKey& key : fault_keys()) {
        const std::string key_path = path + "." + key.name();
        if (const FaultKeyUse* const use = use_of(key, fault.kind); use != nullptr) {
            check.key(key_path, key, use->rule, fault);
        } else {
            check.require(key.value(fault) == key.value(untouched), key_path,
                          misplaced_fault_key(key, fault.kind));
        }
    }
}

bool same_frame(const Fault& one, const Fault& other) {
    return one.renderer == other.renderer && one.pair == other.pair && one.frame == other.frame;
}

/// Every clock must see a reset.
void check_reset(RuleCheck& check, const Scenario& scenario, const Fault& fault, const std::string& path) {
    check.require(fault.cycles.has_value(), path + ".cycles", "is missing; use how long the reset lasts");
    const std::int64_t cycles = fault.cycles.value_or(0);
    const std::int64_t least = least_reset_cycles(scenario.clocks);
    check.require(cycles >= least, path + ".cycles",
                  std::to_string(cycles) + " core cycles are less than two of the slowest clock; use " +
                      std::to_string(least) + " or more");
}

/// Whether two faults of a frame undo or repeat each other, so that their effect would not be clear.
bool clash(const Fault& one, const Fault& other) {
    const auto either = [&](FaultKind first, FaultKind second) {
        return (one.kind == first && other.kind == second) || (one.kind == second && other.kind == first);
    };
    if (either(FaultKind::kShortLine, FaultKind::kLongLine) ||
        either(FaultKind::kShortFrame, FaultKind::kLongFrame)) {
        return true;
    }
    const auto changed_byte = [](const Fault& fault) {
        return fault.kind == FaultKind::kControlByte ? fault.byte : fault_traits(fault.kind).control_offset;
    };
    if (changed_byte(one) >= 0 && changed_byte(one) == changed_byte(other)) return true;
    if (one.kind != other.kind || one.kind == FaultKind::kControlByte) return false;
    if (fault_traits(one.kind).location == FaultLocation::kCharacters) {
        return one.channel == other.channel && one.at_line == other.at_line && one.at_clock == other.at_clock;
    }
    return one.kind != FaultKind::kPixelBits || (one.x == other.x && one.y == other.y);
}

bool gives_another_number(const Fault& fault) {
    return fault.kind == FaultKind::kNumber || fault.kind == FaultKind::kOtherPair;
}

/// At most one frame of a pair may have another pair's number. Nor may frames be left out so that this frame is
/// followed by the depth frame of the pair whose number it has: two halves of different pairs would make a good pair,
/// which nobody could notice.
void check_number(RuleCheck& check, const Scenario& scenario, std::size_t index) {
    const Fault& fault = scenario.faults[index];
    if (!gives_another_number(fault)) return;
    const auto is_missing = [&](std::uint32_t pair, FrameKind frame) {
        return std::any_of(scenario.faults.begin(), scenario.faults.end(), [&](const Fault& other) {
            return other.kind == FaultKind::kMissing && other.renderer == fault.renderer &&
                   other.pair == pair && other.frame == frame;
        });
    };
    for (const Fault& other : scenario.faults) {
        const bool is_another = other.kind != fault.kind || other.frame != fault.frame;
        if (!is_another || !gives_another_number(other) || other.renderer != fault.renderer ||
            other.pair != fault.pair) {
            continue;
        }
        check.require(
            false, fault_path(index) + ".kind",
            (other.kind == fault.kind
                 ? std::string(to_string(fault.kind)) + " on both frames of a pair"
                 : std::string(to_string(fault.kind)) + " and " + to_string(other.kind) + " in one pair") +
                " can make it a good pair of another number; use one of them on one frame");
    }
    check.require(fault.frame != FrameKind::kColour || !is_missing(fault.pair, FrameKind::kDepth) ||
                      !is_missing(fault.pair + 1, FrameKind::kColour),
                  fault_path(index) + ".kind",
                  std::string("with the next two frames missing, ") + to_string(fault.kind) +
                      " makes one good pair of halves of two; let one of those frames come");
}

void check_faults(RuleCheck& check, const Scenario& scenario) {
    if (check.failed()) return;
    const auto renderers = static_cast<std::int64_t>(scenario.renderers.size());
    for (std::size_t i = 0; i < scenario.faults.size(); ++i) {
        const std::string path = fault_path(i);
        const Fault& fault = scenario.faults[i];
        check.require(fault.renderer >= 0 && fault.renderer < renderers, path + ".renderer",
                      std::to_string(fault.renderer) + " is not a renderer's index; use 0 to " +
                          std::to_string(renderers - 1));
        check_fault_keys(check, fault, path);
        if (fault.display > 0) {
            check.integer(path + ".display", fault.display, {1, scenario.displays.count()});
        }
        check.require(scenario.links.tmds() || !fault_traits(fault.kind).needs_tmds(), path + ".kind",
                      std::string(to_string(fault.kind)) +
                          " is in the characters of a link, which has none; use links.layer: tmds");
        check_number(check, scenario, i);
        if (!is_on_link(fault.kind)) continue;
        for (std::size_t j = 0; j < i; ++j) {
            const Fault& earlier = scenario.faults[j];
            if (!is_on_link(earlier.kind) || !same_frame(fault, earlier) || !clash(fault, earlier)) continue;
            check.require(false, path + ".kind",
                          std::string(to_string(fault.kind)) + " does not go together with the " +
                              to_string(earlier.kind) + " of " + fault_path(j) +
                              " in the same frame; use one of them");
        }
        if (check.failed()) return;
    }
}

/// Checks a fault's position in the frame, and a reset's length: the image's size, and with it the link's clock, is
/// known now.
void check_fault_locations(RuleCheck& check, const Scenario& scenario) {
    for (std::size_t i = 0; i < scenario.faults.size(); ++i) {
        const Fault& fault = scenario.faults[i];
        const Renderer& renderer = scenario.renderers[static_cast<std::size_t>(fault.renderer)];
        const int width = renderer.image_width_pixels;
        const int height = renderer.image_height_pixels;
        const auto within = [&](const char* key, int value, const IntegerRange& allowed,
                                const char* of_what) {
            check.require(allowed.contains(value), fault_path(i) + "." + key,
                          text::out_of_range(value, allowed) + ", " + of_what);
        };
        within("lines", fault.lines, {1, height}, "the lines of the image");
        within("byte", fault.byte, {0, std::int64_t{width} * kLinkBytesPerPixel - 1},
               "the bytes of the control scanline");
        within("x", fault.x, {0, width - 1}, "the columns of the image");
        within("y", fault.y, {0, height - 1}, "the rows of the image");
        const DviTiming mode = renderer.timing();
        within("at_line", fault.at_line, {0, mode.frame_lines() - 1}, "the lines of the link's mode");
        within("at_clock", fault.at_clock, {0, mode.line_clocks() - 1}, "the clocks of its lines");
        if (fault.kind == FaultKind::kReset) check_reset(check, scenario, fault, fault_path(i));
        const std::string kind = to_string(fault.kind);
        const bool changes_number = fault.kind == FaultKind::kNumber || fault.kind == FaultKind::kKind;
        check.require(!changes_number || !renderer.frame_of_pair(fault.pair).controls,
                      fault_path(i) + ".kind",
                      kind +
                          " changes control scanlines that the host makes, and the pair has controls; use "
                          "other controls");
        const bool keeps_pair_away = fault.kind == FaultKind::kMissing || fault.kind == FaultKind::kDelay;
        check.require(!renderer.is_live || !keeps_pair_away, fault_path(i) + ".kind",
                      kind +
                          " says whether a pair comes, and that of a live renderer comes from its "
                          "application; use another kind");
    }
}

void check_image_size(RuleCheck& check, const Renderer& renderer, const StoredImage& image,
                      const std::string& path) {
    const auto size = [](int width, int height) {
        return std::to_string(width) + " x " + std::to_string(height) + " pixels";
    };
    check.require(image.width_pixels() == renderer.image_width_pixels &&
                      image.height_pixels() == renderer.image_height_pixels,
                  path,
                  "the image has " + size(image.width_pixels(), image.height_pixels()) +
                      ", and the renderer's first " +
                      size(renderer.image_width_pixels, renderer.image_height_pixels) +
                      "; use images of one size, the renderer's DVI mode");
}

/// What an image in memory must be whichever renderer sends it.
void check_pixels(RuleCheck& check, const Scenario& scenario, const PixelImage& image,
                  const std::string& path) {
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(image.width_pixels) * static_cast<std::uint64_t>(image.height_pixels);
    check.require(image.values.size() == pixels, path,
                  "the image holds " + std::to_string(image.values.size()) + " pixels; use width x height");
    const std::uint32_t far = far_z(scenario.depth_format);
    const bool fits = std::all_of(image.values.begin(), image.values.end(),
                                  [far](const Pixel& pixel) { return pixel.z() <= far; });
    check.require(fits, path,
                  "the image has a Z beyond the far plane of " +
                      std::string(to_string(scenario.depth_format)) + "; use 0 to " + std::to_string(far));
}

void check_table(RuleCheck& check, const Renderer& renderer, const RendererFrame& frame,
                 const std::string& path) {
    ControlScanline content;
    content.table = frame.table;
    const std::size_t needed = control_scanline_bytes(content);
    const std::size_t available =
        static_cast<std::size_t>(renderer.image_width_pixels) * std::size_t{kLinkBytesPerPixel};
    check.require(
        needed <= available, path + (frame.viewport.has_value() ? ".viewport" : ".table"),
        "the table of " + std::to_string(frame.table.size()) + " rows needs " + std::to_string(needed) +
            " bytes and the control scanline of an image " + std::to_string(renderer.image_width_pixels) +
            " pixels wide has " + std::to_string(available) + "; use fewer rows or an image at least " +
            std::to_string((needed + kLinkBytesPerPixel - 1) / kLinkBytesPerPixel) + " pixels wide");
}

/// A slot table that the scenario gives can be sent. Whether the machine accepts it is not checked.
void check_slots(RuleCheck& check, const Renderer& renderer, const RendererFrame& frame,
                 const std::string& path) {
    if (!frame.slots || frame.slots->empty()) return;
    for (const int display : *frame.slots) {
        const bool has_row = std::any_of(frame.table.begin(), frame.table.end(),
                                         [display](const ViewportRow& row) { return row.dcomp == display; });
        check.require(has_row, path + ".slots",
                      "display " + std::to_string(display) + " has no row; use displays that have one");
        if (!has_row) return;
    }
    const std::size_t room =
        slots_in_payload(payload_room_bytes(renderer.image_width_pixels), frame.table.size());
    check.require(frame.slots->size() <= room, path + ".slots",
                  std::to_string(frame.slots->size()) +
                      " slots do not fit the control scanline of an image " +
                      std::to_string(renderer.image_width_pixels) + " pixels wide; use " +
                      std::to_string(room) + " at the most or a wider image");
}

}  // namespace

std::string same_depths(double depth) {
    return "near and far are both " + text::number(depth) + "; use two different depths";
}

std::optional<RuleViolation> settings_violation(const Scenario& scenario) {
    RuleCheck check;
    const ClockConfig& clocks = scenario.clocks;
    if (clocks.given_dvi_out_refresh_hz) {
        check_refresh_rate(check, "dvi_out", *clocks.given_dvi_out_refresh_hz, scenario.displays.timing(),
                           clocks.dvi_out_mhz);
    }
    check_keys(check, scenario);
    check_machine(check, scenario);
    check_corrections(check, scenario.displays);
    check_names(check, scenario);
    check_faults(check, scenario);
    return std::move(check).result();
}

std::optional<RuleViolation> renderers_violation(const Scenario& scenario) {
    RuleCheck check;
    check_link_refresh_rate(check, scenario);
    // Many renderers may share an image, and its pixels take longest to check.
    std::set<const StoredImage*> known;
    for (std::size_t i = 0; i < scenario.renderers.size(); ++i) {
        const Renderer& renderer = scenario.renderers[i];
        const std::string path = "renderers[" + std::to_string(i) + "]";
        check.integer(path + ".frames", renderer.image_width_pixels, kImageSidePixels);
        check.integer(path + ".frames", renderer.image_height_pixels, kImageSidePixels);
        check_write_blocks(check, scenario, i, path);
        std::set<std::size_t> seen;
        for (std::size_t j = 0; j < renderer.frames.size(); ++j) {
            const RendererFrame& frame = renderer.frames[j];
            const std::string frame_path = path + ".frames[" + std::to_string(j) + "]";
            if (frame.image >= renderer.images.size()) {
                check.require(false, frame_path + ".image",
                              std::to_string(frame.image) + " is not an image's index; use 0 to " +
                                  std::to_string(renderer.images.size()) + ", exclusive");
                continue;
            }
            const StoredImage* image = renderer.images[frame.image].get();
            if (image == nullptr) {
                check.require(
                    false, frame_path + ".image",
                    std::to_string(frame.image) + " has no image; use the index of one that is there");
                continue;
            }
            if (seen.insert(frame.image).second) {
                check_image_size(check, renderer, *image, frame_path + ".image");
            }
            if (known.insert(image).second && image->is_read()) {
                check_pixels(check, scenario, image->pixels(), frame_path + ".image");
            }
            check_table(check, renderer, frame, frame_path);
            if (!check.failed()) check_slots(check, renderer, frame, frame_path);
        }
    }
    if (!check.failed()) check_fault_locations(check, scenario);
    return std::move(check).result();
}

void check_scenario(const Scenario& scenario) {
    std::optional<RuleViolation> violation = settings_violation(scenario);
    if (!violation.has_value()) violation = renderers_violation(scenario);
    if (violation.has_value()) throw InputError(text::one_line(violation->path + ": " + violation->message));
}

}  // namespace metabuffer
