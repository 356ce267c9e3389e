#include "scenario/scenario_keys.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/text.h"
#include "scenario/fault_keys.h"
#include "scenario/limits.h"

namespace metabuffer {
namespace {

using object_key::choice;
using object_key::number;
using object_key::one_of;
using object_key::otherwise;
using object_key::required;
using object_key::row;
using object_key::whole_number;

constexpr IntegerRange kDisplayPixels{1, 4096};
constexpr std::array<int, 3> kSupersamples{1, 2, 4};
static_assert(kDisplayPixels.high * kSupersamples.back() <= std::numeric_limits<std::int16_t>::max(),
              "a row's place on the raster, dx and dy, is an int16");
constexpr IntegerRange kViewportPosition{-1'000'000'000, 1'000'000'000};
constexpr IntegerRange kGapRasterPixels{0, 65535};
constexpr NumberRange kClockMhz{0.001, 10000.0};
constexpr NumberRange kRefreshHz{0.001, 1e9};
constexpr NumberRange kDepth{-1e30, 1e30};
constexpr NumberRange kGain{0.001, 1000.0};
constexpr NumberRange kGamma{0.01, 100.0};
constexpr const char* kCorrection = "displays.correction";

ObjectKey<Scenario> map(const char* path) { return {{path, KeyShape::kMap, "a map"}}; }

/// A list that always has `length` numbers; the row of its entries follows it.
SchemaKey numbers(const char* path, const char* meaning, std::size_t length, const char* fallback = "") {
    SchemaKey key{path, KeyShape::kList, meaning};
    key.length = length;
    key.fallback = fallback;
    return key;
}

/// A key in a list, or one that is read by separate code.
SchemaKey scalar(const char* path, const char* meaning, ValueRule::Type type = ValueRule::Type::kText,
                 const char* fallback = "required") {
    SchemaKey key{path, KeyShape::kScalar, meaning};
    key.rule.type = type;
    key.fallback = fallback;
    return key;
}

ObjectKey<Scenario> depth_range() {
    ObjectKey<Scenario> key{numbers(
        "depth_range", "a list of two numbers, [near, far]; near > far if larger ones are nearer", 2)};
    key.value = [](const Scenario& scenario) {
        const ImageReading& reading = scenario.image_reading;
        return std::optional<KeyValue>(std::vector<double>{reading.near, reading.far});
    };
    key.set = [](Scenario& scenario, const KeyValue& value) {
        const auto& ends = std::get<std::vector<double>>(value);
        scenario.image_reading.near = ends[0];
        scenario.image_reading.far = ends[1];
    };
    key.schema.fallback = value_text(*key.value(Scenario()));
    return key;
}

/// Its numbers may be infinite or none, so the reader has code of its own for it.
ObjectKey<Scenario> depth_nothing() {
    ObjectKey<Scenario> key{
        {"depth_nothing", KeyShape::kList,
         "a list of numbers, nan or inf: the depths in image files that mean nothing is there"}};
    key.schema.may_be_one = true;
    key.schema.fallback = "none";
    key.value = [](const Scenario& scenario) {
        const ImageReading& reading = scenario.image_reading;
        std::vector<std::string> samples;
        for (const double sample : reading.nothing) {
            samples.push_back(std::isinf(sample) ? (sample < 0 ? "-inf" : "inf") : text::number(sample));
        }
        if (reading.nan_is_nothing) samples.emplace_back("nan");
        return std::optional<KeyValue>("[" + text::listed(samples) + "]");
    };
    return key;
}

template <auto Member>
constexpr TableField field(const char* name, const IntegerRange& range) {
    return {name, range, [](const ViewportRow& table_row) { return std::int64_t{table_row.*Member}; },
            [](ViewportRow& table_row, std::int64_t value) {
                table_row.*Member = static_cast<std::decay_t<decltype(table_row.*Member)>>(value);
            }};
}

std::vector<SchemaKey> correction_keys() {
    std::vector<SchemaKey> keys{{"displays.correction[]", KeyShape::kMap, "a map"}};
    for (const ObjectKey<DisplayCorrection>& key : correction_rows()) keys.push_back(key.schema);
    keys.push_back(scalar("displays.correction[].lut",
                          "a file of 256 rows of R, G, B as CSV, instead of gain and gamma",
                          ValueRule::Type::kText, "none"));
    return keys;
}

std::vector<SchemaKey> renderer_keys() {
    std::vector<SchemaKey> keys{
        {"renderers", KeyShape::kList, "a list of renderers"},
        {"renderers[]", KeyShape::kMap, "a map"},
        scalar("renderers[].name", "the renderer's name", ValueRule::Type::kText,
               "renderer_1, renderer_2, ..."),
        {"renderers[].copies", KeyShape::kScalar, "how many renderers of these frames",
         ValueRule::whole_numbers({1, limits::kComposers}), "renderers", "1"},
        {"renderers[].live", KeyShape::kMap,
         "a map: in place of frames, the size of the images that an application sends (metabuffer live)"},
        {"renderers[].live.width", KeyShape::kScalar, "image pixels",
         ValueRule::whole_numbers(kImageSidePixels), "required in live"},
        {"renderers[].live.height", KeyShape::kScalar, "image pixels",
         ValueRule::whole_numbers(kImageSidePixels), "required in live"},
        {"renderers[].frames", KeyShape::kList,
         "a list of frames, each with an image and a viewport, a table or controls"},
        {"renderers[].frames[]", KeyShape::kMap, "a map"},
        scalar("renderers[].frames[].image", "a file name"),
        scalar("renderers[].frames[].layer", "a layer, or a part, of the image's colours",
               ValueRule::Type::kText, "R, G and B, or the only one"),
        scalar("renderers[].frames[].depth", "a file name", ValueRule::Type::kText, "Z of the image"),
        scalar("renderers[].frames[].depth_layer",
               "a layer, a part or a channel of Z, of the image or of depth", ValueRule::Type::kText,
               "Z, or the only one"),
        numbers("renderers[].frames[].depth_range", "a list of two numbers, [near, far], of this image", 2,
                "the scenario's"),
        {"renderers[].frames[].depth_range[]", KeyShape::kScalar, "near or far", ValueRule::numbers(kDepth)},
        scalar("renderers[].frames[].frames",
               "the numbers of many frames, such as 0-299, which file names have as %d or %04d",
               ValueRule::Type::kText, "one frame"),
        {"renderers[].frames[].z", KeyShape::kScalar,
         "one depth for all of the image, within its depth_range", ValueRule::numbers(kDepth), "",
         "Z of the image"},
        {"renderers[].frames[].viewport", KeyShape::kMap, "a map"}};
    for (const ObjectKey<Viewport>& key : viewport_rows()) {
        keys.push_back(key.schema);
        if (key.required) keys.back().fallback = "required without path";
    }
    keys.push_back(
        {"renderers[].frames[].viewport.path", KeyShape::kList,
         "a list of positions, each with frame, x and y, between which the viewport moves evenly"});
    keys.push_back({"renderers[].frames[].viewport.path[]", KeyShape::kMap, "a map"});
    for (const ObjectKey<input::PathPosition>& key : path_rows()) keys.push_back(key.schema);
    keys.push_back({"renderers[].frames[].table", KeyShape::kList,
                    "a list of rows, each [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]"});
    keys.push_back({"renderers[].frames[].table[]", KeyShape::kList,
                    "a row of eight whole numbers, [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]"});
    keys.push_back({"renderers[].frames[].table[][]", KeyShape::kScalar, "a field of a row"});
    keys.push_back({"renderers[].frames[].slots",
                    KeyShape::kList,
                    "the slot table that the host sends, a list of displays",
                    {},
                    "",
                    "by C / T of each row"});
    keys.push_back({"renderers[].frames[].slots[]", KeyShape::kScalar, "a display"});
    keys.push_back({"renderers[].frames[].controls", KeyShape::kList,
                    "the bytes of both control scanlines in hexadecimal digits, [colour, depth]"});
    keys.push_back({"renderers[].frames[].controls[]", KeyShape::kScalar,
                    "the bytes of a control scanline in hexadecimal digits"});
    return keys;
}

std::vector<SchemaKey> all_keys() {
    std::vector<SchemaKey> keys;
    for (const ObjectKey<Scenario>& key : setting_rows()) {
        keys.push_back(key.schema);
        if (key.schema.pattern != std::string(kCorrection)) continue;
        for (const SchemaKey& each : correction_keys()) keys.push_back(each);
    }
    for (const SchemaKey& key : renderer_keys()) keys.push_back(key);
    keys.push_back({"faults", KeyShape::kList, "a list of faults"});
    keys.push_back({"faults[]", KeyShape::kMap, "a map"});
    keys.push_back(scalar("faults[].renderer", "a renderer's name"));
    for (const FaultKey& key : fault_keys()) {
        keys.push_back(key.schema);
        if (keys.back().pattern != std::string("faults[].pair")) continue;
        keys.push_back({"faults[].kind", KeyShape::kScalar, "what goes wrong",
                        ValueRule::choice_of<FaultKind>(), "", "required"});
    }
    return keys;
}

constexpr IntegerRange kPageMissCycles{0, 1'000'000};

/// If a refresh rate gives it, it is known only when the images are: their size sets the mode (scenario_reader).
ObjectKey<Scenario> dvi_in_mhz() {
    ObjectKey<Scenario> key = otherwise(
        number<&Scenario::clocks, &ClockConfig::dvi_in_mhz>("clocks.dvi_in_mhz", "MHz",
                                                            "pixel clock of the renderers' links", kClockMhz),
        "by dvi_in_refresh_hz if that is given, else 100", +[](const Scenario& scenario) -> KeyValue {
            return scenario.clocks.given_dvi_in_refresh_hz ? 0.0 : ClockConfig().dvi_in_mhz;
        });
    key.value = [](const Scenario& scenario) {
        const ClockConfig& clocks = scenario.clocks;
        return clocks.dvi_in_is_known() ? std::optional<KeyValue>(clocks.dvi_in_mhz) : std::nullopt;
    };
    return key;
}

/// It follows from page_miss_cycles: one of the two may be given, or both if they agree (scenario_rules).
ObjectKey<Scenario> activate_cycles() {
    ObjectKey<Scenario> key;
    key.schema = {"memory.activate_cycles",
                  KeyShape::kScalar,
                  "cycles to open a page in a closed bank",
                  ValueRule::whole_numbers(kPageMissCycles),
                  "core cycles",
                  "page_miss_cycles - precharge_cycles"};
    key.value = [](const Scenario& scenario) -> std::optional<KeyValue> {
        const MemoryConfig& memory = scenario.memory;
        return KeyValue(
            std::int64_t{memory.given_activate_cycles.value_or(std::max(0, memory.activate_cycles()))});
    };
    key.set = [](Scenario& scenario, const KeyValue& value) {
        scenario.memory.given_activate_cycles = static_cast<int>(std::get<std::int64_t>(value));
    };
    return key;
}

}  // namespace

const std::vector<ObjectKey<Scenario>>& setting_rows() {
    static const std::vector<ObjectKey<Scenario>> rows{
        map(""),
        otherwise(row<&Scenario::name>(scalar("name", "the scenario's name")), "the file's name"),
        map("displays"),
        whole_number<&Scenario::displays, &DisplayConfig::columns>(
            "displays.columns", "displays", "displays side by side", limits::kGridDisplays),
        whole_number<&Scenario::displays, &DisplayConfig::rows>(
            "displays.rows", "displays", "displays one above the other", limits::kGridDisplays),
        required(whole_number<&Scenario::displays, &DisplayConfig::width_pixels>(
            "displays.width", "pixels", "width of one display", kDisplayPixels)),
        required(whole_number<&Scenario::displays, &DisplayConfig::height_pixels>(
            "displays.height", "pixels", "height of one display", kDisplayPixels)),
        one_of<&Scenario::displays, &DisplayConfig::supersample>(
            "displays.supersample", "", "raster pixels per display pixel and axis",
            {kSupersamples.begin(), kSupersamples.end()}, "a supersampling"),
        row<&Scenario::displays, &DisplayConfig::background>(
            numbers("displays.background", "a list of three whole numbers 0 to 255, [R, G, B]", 3)),
        {{"displays.background[]", KeyShape::kScalar, "one of R, G, B", ValueRule::whole_numbers({0, 255})}},
        map("displays.gap"),
        whole_number<&Scenario::displays, &DisplayConfig::gap, &DisplayGap::x_raster_pixels>(
            "displays.gap.x", "raster pixels", "hidden between displays side by side", kGapRasterPixels),
        whole_number<&Scenario::displays, &DisplayConfig::gap, &DisplayGap::y_raster_pixels>(
            "displays.gap.y", "raster pixels", "hidden between displays one above the other",
            kGapRasterPixels),
        {{kCorrection, KeyShape::kList, "a list of displays whose colours are corrected", {}, "", "none"}},
        choice<Composition, &Scenario::composition>("composition", "how a composer merges two pixels"),
        choice<DepthFormat, &Scenario::depth_format>("depth_format", "the layout of a depth frame's pixel"),
        depth_range(),
        {{"depth_range[]", KeyShape::kScalar, "near or far", ValueRule::numbers(kDepth)}},
        depth_nothing(),
        {{"depth_nothing[]", KeyShape::kScalar, "a number, nan, inf or -inf"}},
        choice<DepthIntegers, &Scenario::image_reading, &ImageReading::integers>(
            "depth_integers",
            "Z of whole numbers in image files: shares of the largest that their bits hold, or as it is "
            "sent"),
        choice<DepthBits, &Scenario::image_reading, &ImageReading::bits>(
            "depth_bits", "where a file of Z has its bits: in one channel, or in R, G and B of 8 bits"),
        choice<ColourEncoding, &Scenario::image_reading, &ImageReading::colours>(
            "colour_encoding",
            "what colours of floats in image files become: the same, or, since they are linear, sRGB"),
        map("clocks"),
        number<&Scenario::clocks, &ClockConfig::core_mhz>("clocks.core_mhz", "MHz",
                                                          "clock of buses and composers", kClockMhz),
        otherwise(
            number<&Scenario::clocks, &ClockConfig::given_dvi_in_refresh_hz>(
                "clocks.dvi_in_refresh_hz", "Hz",
                "frames a second on the renderers' links, two a pair; instead of dvi_in_mhz", kRefreshHz),
            "by dvi_in_mhz"),
        dvi_in_mhz(),
        otherwise(number<&Scenario::clocks, &ClockConfig::given_dvi_out_refresh_hz>(
                      "clocks.dvi_out_refresh_hz", "Hz",
                      "frames a second of the displays; instead of dvi_out_mhz", kRefreshHz),
                  "by dvi_out_mhz"),
        otherwise(
            number<&Scenario::clocks, &ClockConfig::dvi_out_mhz>("clocks.dvi_out_mhz", "MHz",
                                                                 "pixel clock of the displays", kClockMhz),
            "by dvi_out_refresh_hz if that is given, else 100",
            +[](const Scenario& scenario) -> KeyValue {
                const std::optional<double>& refresh_hz = scenario.clocks.given_dvi_out_refresh_hz;
                return refresh_hz ? mhz_of_refresh(*refresh_hz, scenario.displays.timing())
                                  : ClockConfig().dvi_out_mhz;
            }),
        map("memory"),
        whole_number<&Scenario::memory, &MemoryConfig::page_words>(
            "memory.page_words", "words", "words of an open page", limits::kPageWords),
        one_of<&Scenario::memory, &MemoryConfig::banks>(
            "memory.banks", "banks", "banks of the memory, each with an open page",
            {limits::kMemoryBanks.begin(), limits::kMemoryBanks.end()}, "a number of banks"),
        whole_number<&Scenario::memory, &MemoryConfig::precharge_cycles>(
            "memory.precharge_cycles", "core cycles", "cycles to close a bank's page",
            limits::kPrechargeCycles),
        activate_cycles(),
        otherwise(
            whole_number<&Scenario::memory, &MemoryConfig::page_miss_cycles>(
                "memory.page_miss_cycles", "core cycles", "cycles to close a page and open another",
                kPageMissCycles),
            "precharge_cycles + activate_cycles if that is given, else 6",
            +[](const Scenario& scenario) -> KeyValue {
                const MemoryConfig& memory = scenario.memory;
                return memory.given_activate_cycles
                           ? std::int64_t{memory.precharge_cycles} + *memory.given_activate_cycles
                           : std::int64_t{MemoryConfig().page_miss_cycles};
            }),
        whole_number<&Scenario::memory, &MemoryConfig::words_per_cycle>(
            "memory.words_per_cycle", "words", "words per cycle of the open page", limits::kWordsPerCycle),
        whole_number<&Scenario::memory, &MemoryConfig::read_latency_cycles>(
            "memory.read_latency_cycles", "core cycles",
            "cycles from a read to its words; a read may follow in each cycle", limits::kReadLatencyCycles),
        whole_number<&Scenario::memory, &MemoryConfig::refresh_interval_cycles>(
            "memory.refresh_interval_cycles", "core cycles",
            "cycles from one refresh to the next; 0 for none", limits::kRefreshIntervalCycles),
        whole_number<&Scenario::memory, &MemoryConfig::refresh_cycles>(
            "memory.refresh_cycles", "core cycles", "cycles of a refresh, which closes all banks",
            limits::kRefreshCycles),
        choice<MemoryPorts, &Scenario::memory, &MemoryConfig::ports>(
            "memory.ports",
            "two devices, one for the link and one for the bus, or one whose data pins both share"),
        whole_number<&Scenario::memory, &MemoryConfig::write_block_words>(
            "memory.write_block_words", "words",
            "with shared ports: words of the link that are written together", limits::kPageWords),
        map("bus"),
        one_of<&Scenario::bus, &BusConfig::width_bits>(
            "bus.width_bits", "bits", "width of a bus",
            {limits::kBusWidthsBits.begin(), limits::kBusWidthsBits.end()}, "a bus width"),
        whole_number<&Scenario::bus, &BusConfig::burst_pixels>("bus.burst_pixels", "pixels",
                                                               "most pixels of a burst", {1, 65535}),
        choice<Arbitration, &Scenario::bus, &BusConfig::arbitration>("bus.arbitration",
                                                                     "who is next on the bus"),
        whole_number<&Scenario::bus, &BusConfig::grant_cycles>("bus.grant_cycles", "core cycles",
                                                               "cycles that the arbiter takes for an answer",
                                                               limits::kGrantCycles),
        choice<SlotTableMaker, &Scenario::bus, &BusConfig::slot_table>(
            "bus.slot_table",
            "who makes the slot table: the host, which sends it with the pair, or the arbiter, a slot a "
            "cycle"),
        whole_number<&Scenario::bus, &BusConfig::register_stages>(
            "bus.register_stages", "registers",
            "registers on the way from an input framebuffer to its composers, and as many on the way back",
            limits::kRegisterStages),
        map("composer"),
        whole_number<&Scenario::composer, &ComposerConfig::buffer_pixels>(
            "composer.buffer_pixels", "pixels", "pixels of a composer's buffer", limits::kBufferPixels),
        otherwise(
            whole_number<&Scenario::composer, &ComposerConfig::ready_space_pixels>(
                "composer.ready_space_pixels", "pixels",
                "free pixels at which a composer is ready for a burst", limits::kBufferPixels),
            "one burst, at least what can be in flight",
            +[](const Scenario& scenario) -> KeyValue {
                return std::int64_t{default_ready_space_pixels(scenario.bus, scenario.memory)};
            }),
        choice<StarvationMode, &Scenario::composer, &ComposerConfig::on_starvation>(
            "composer.on_starvation", "what happens when a local pixel has not come in time"),
        choice<Smoothing, &Scenario::composer, &ComposerConfig::smoothing>(
            "composer.smoothing",
            "how a composer magnifies: it repeats each source pixel, or mixes those around a raster pixel"),
        map("links"),
        choice<LinkLayer, &Scenario::links, &LinkConfig::layer>(
            "links.layer",
            "what a DVI link is made of: pixels, or TMDS characters with an encoder and a decoder"),
        choice<Pacing, &Scenario::pacing>("pacing", "whether a frame waits for a new pair of every renderer"),
        whole_number<&Scenario::link_timeout_pairs>(
            "link_timeout_pairs", "pair times", "after which a missing pair is replaced by the last good one",
            {1, 1'000'000}),
        whole_number<&Scenario::watchdog_cycles>(
            "watchdog_cycles", "core cycles",
            "cycles without movement that end a run; 0 for a value derived "
            "from the scenario",
            limits::kCycles),
        otherwise(whole_number<&Scenario::frames>("frames", "frames", "composited frames", limits::kFrames),
                  "the longest of the renderers' lists"),
    };
    return rows;
}

const std::vector<ObjectKey<DisplayCorrection>>& correction_rows() {
    static const std::vector<ObjectKey<DisplayCorrection>> rows{
        required(whole_number<&DisplayCorrection::display>(
            "displays.correction[].display", "", "a display, from 1",
            {1, limits::kGridDisplays.high * limits::kGridDisplays.high})),
        row<&DisplayCorrection::gain>(numbers("displays.correction[].gain",
                                              "a list of three numbers, [R, G, B]", ColourTable::kChannels)),
        {{"displays.correction[].gain[]", KeyShape::kScalar, "what R, G or B is multiplied by",
          ValueRule::numbers(kGain)}},
        number<&DisplayCorrection::gamma>("displays.correction[].gamma", "",
                                          "R, G and B, as shares of 255, are raised to 1 / gamma", kGamma),
    };
    return rows;
}

const std::vector<ObjectKey<Viewport>>& viewport_rows() {
    static const std::vector<ObjectKey<Viewport>> rows{
        required(whole_number<&Viewport::x>("renderers[].frames[].viewport.x", "raster pixels",
                                            "left edge in the display space", kViewportPosition)),
        required(whole_number<&Viewport::y>("renderers[].frames[].viewport.y", "raster pixels",
                                            "top edge in the display space", kViewportPosition)),
        whole_number<&Viewport::multiple>("renderers[].frames[].viewport.multiple", "raster pixels",
                                          "raster pixels per source pixel and axis", {1, kMaximumMultiple}),
    };
    return rows;
}

const std::vector<ObjectKey<input::PathPosition>>& path_rows() {
    using input::PathPosition;
    static const std::vector<ObjectKey<PathPosition>> rows{
        required(whole_number<&PathPosition::frame>("renderers[].frames[].viewport.path[].frame", "frames",
                                                    "number of the frame, as in frames",
                                                    {0, std::numeric_limits<int>::max()})),
        required(whole_number<&PathPosition::viewport, &Viewport::x>(
            "renderers[].frames[].viewport.path[].x", "raster pixels", "left edge in that frame",
            kViewportPosition)),
        required(whole_number<&PathPosition::viewport, &Viewport::y>(
            "renderers[].frames[].viewport.path[].y", "raster pixels", "top edge in that frame",
            kViewportPosition)),
        otherwise(
            whole_number<&PathPosition::viewport, &Viewport::multiple>(
                "renderers[].frames[].viewport.path[].multiple", "raster pixels",
                "raster pixels per source pixel and axis, up to the next position", {1, kMaximumMultiple}),
            "as before, at first 1"),
    };
    return rows;
}

const std::array<TableField, 8>& table_fields() {
    static constexpr std::array<TableField, 8> fields{
        field<&ViewportRow::dcomp>("Dcomp", limits::kUnsignedField),
        field<&ViewportRow::sx>("Sx", limits::kUnsignedField),
        field<&ViewportRow::sy>("Sy", limits::kUnsignedField),
        field<&ViewportRow::sdx>("Sdx", limits::kUnsignedField),
        field<&ViewportRow::sdy>("Sdy", limits::kUnsignedField),
        field<&ViewportRow::dx>("Dx", limits::kSignedField),
        field<&ViewportRow::dy>("Dy", limits::kSignedField),
        field<&ViewportRow::dmultiple>("Dmultiple", limits::kUnsignedField),
    };
    return fields;
}

const Schema& scenario_schema() {
    static const Schema schema{"the scenario is empty; use at least the keys displays and renderers",
                               all_keys()};
    return schema;
}

}  // namespace metabuffer
