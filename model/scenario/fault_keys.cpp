#include "scenario/fault_keys.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>

#include "host/errors.h"
#include "host/text.h"
#include "scenario/fault_kinds.h"
#include "scenario/limits.h"

namespace metabuffer {
namespace {

using object_key::choice;
using object_key::otherwise;
using object_key::required;
using object_key::whole_number;

constexpr const char* kList = "faults[].";

const FaultKey& key_named(std::string_view name) {
    const std::vector<FaultKey>& keys = fault_keys();
    const auto found =
        std::find_if(keys.begin(), keys.end(), [name](const FaultKey& key) { return key.name() == name; });
    if (found == keys.end()) throw std::logic_error("no key of a fault: " + std::string(name));
    return *found;
}

using Uses = std::vector<FaultKeyUse>;

std::map<FaultKind, Uses> uses_by_kind() {
    std::map<FaultKind, Uses> result;
    for (const FaultTraits& traits : kFaultKinds) {
        Uses& uses = result[traits.value];
        for (const FaultKeyOfKind& of_kind : traits.keys) {
            if (of_kind.name == nullptr) break;
            const FaultKey& key = key_named(of_kind.name);
            FaultKeyUse use{&key, key.schema.rule, key.required || of_kind.required};
            if (of_kind.range.low <= of_kind.range.high) use.rule.whole = of_kind.range;
            uses.push_back(std::move(use));
        }
    }
    return result;
}

std::vector<std::string> kinds_with(const FaultKey& key) {
    std::vector<std::string> names;
    for (const FaultTraits& kind : kFaultKinds) {
        if (use_of(key, kind.value) != nullptr) names.emplace_back(kind.name);
    }
    return names;
}

}  // namespace

const char* FaultKey::name() const { return schema.pattern + std::strlen(kList); }

const std::vector<FaultKey>& fault_keys() {
    // The image, or its link, sets narrower bounds once it is known.
    constexpr IntegerRange kPosition{0, kImageSidePixels.high - 1};
    constexpr IntegerRange kOneOrMoreCycles{1, limits::kCycles.high};
    constexpr DviTiming kLargestMode =
        renderer_dvi_timing(static_cast<int>(kImageSidePixels.high), static_cast<int>(kImageSidePixels.high));
    constexpr std::int64_t kMostLinkLines = kLargestMode.frame_lines();
    constexpr std::int64_t kMostLineClocks = kLargestMode.line_clocks();
    static const std::vector<FaultKey> keys{
        {required(whole_number<&Fault::pair>("faults[].pair", "", "the pair's number, from 0",
                                             {0, std::numeric_limits<std::uint32_t>::max()}))},
        {choice<FrameKind, &Fault::frame>("faults[].frame", "which frame of the pair")},
        {required(whole_number<&Fault::delay_pairs>("faults[].delay_pairs", "pair times",
                                                    "how long the link is silent", {1, 1'000'000}))},
        {whole_number<&Fault::lines>("faults[].lines", "scanlines", "missing or added",
                                     {1, kImageSidePixels.high})},
        {required(whole_number<&Fault::byte>("faults[].byte", "", "a byte of the control scanline, from 0",
                                             {0, kLinkBytesPerPixel * kImageSidePixels.high - 1}))},
        {required(whole_number<&Fault::bits>("faults[].bits", "", "the bits to flip", {1, 0xFF'FFFF}))},
        {required(whole_number<&Fault::x>("faults[].x", "image pixels", "column of the pixel", kPosition))},
        {required(whole_number<&Fault::y>("faults[].y", "image pixels", "row of the pixel", kPosition))},
        {required(whole_number<&Fault::ppm>("faults[].ppm", "ppm", "millionths that the clock is fast",
                                            {-100'000, 100'000}))},
        {required(
            whole_number<&Fault::display>("faults[].display", "", "a display, from 1",
                                          {1, limits::kGridDisplays.high * limits::kGridDisplays.high}))},
        {whole_number<&Fault::from_cycle>("faults[].from_cycle", "core cycles", "when it begins",
                                          limits::kCycles)},
        {otherwise(
            whole_number<&Fault::cycles>("faults[].cycles", "core cycles", "how long", kOneOrMoreCycles),
            "for ever")},
        {whole_number<&Fault::beats>("faults[].beats", "beats", "how many are lost", {1, 1'000'000'000})},
        {choice<LostBeats, &Fault::of>("faults[].of", "which beats")},
        {required(whole_number<&Fault::percent>("faults[].percent", "%", "share of the clocks", {1, 99}))},
        {whole_number<&Fault::seed>("faults[].seed", "", "any whole number", limits::kCycles)},
        {required(choice<TmdsChannel, &Fault::channel>("faults[].channel", "which channel of the link"))},
        {required(whole_number<&Fault::at_line>("faults[].at_line", "lines",
                                                "line of the frame on the link, blanking included, from 0",
                                                {0, kMostLinkLines - 1}))},
        {required(whole_number<&Fault::at_clock>("faults[].at_clock", "clocks of the link",
                                                 "clock of the line, blanking included, from 0",
                                                 {0, kMostLineClocks - 1}))},
        {required(whole_number<&Fault::late_bits>("faults[].late_bits", "bits", "from then on; 0: in step",
                                                  {0, kTmdsCharacterBits - 1}))},
        {required(whole_number<&Fault::late_characters>("faults[].late_characters", "characters",
                                                        "from then on; 0: in step", {0, kMostTmdsSkew}))},
        {required(whole_number<&Fault::per_billion>(
            "faults[].per_billion", "", "flipped bits of a billion, at random", {1, 1'000'000'000}))},
    };
    return keys;
}

const std::vector<FaultKeyUse>& fault_keys_of(FaultKind kind) {
    static const std::map<FaultKind, Uses> uses = uses_by_kind();
    return uses.at(kind);
}

const FaultKeyUse* use_of(const FaultKey& key, FaultKind kind) {
    const Uses& uses = fault_keys_of(kind);
    const auto found =
        std::find_if(uses.begin(), uses.end(), [&key](const FaultKeyUse& use) { return use.key == &key; });
    return found == uses.end() ? nullptr : &*found;
}

std::string misplaced_fault_key(const FaultKey& key, FaultKind kind) {
    constexpr std::size_t kFewKinds = 4;
    const std::string text = std::string("does not go with kind ") + to_string(kind) + "; ";
    const std::vector<std::string> kinds = kinds_with(key);
    if (kinds.size() <= kFewKinds) {
        return text + "use it with kind " + text::joined(kinds, "or") + " only";
    }
    std::vector<std::string> keys{"kind"};
    if (fault_traits(kind).names_renderer()) keys.insert(keys.begin(), "renderer");
    for (const FaultKeyUse& use : fault_keys_of(kind)) keys.emplace_back(use.key->name());
    return text + "its keys are " + text::joined(keys, "and");
}

bool is_on_link(FaultKind kind) {
    const FaultLocation location = fault_traits(kind).location;
    return location == FaultLocation::kFrame || location == FaultLocation::kLink ||
           location == FaultLocation::kCharacters;
}

bool disturbs_characters(const Scenario& scenario, std::size_t renderer) {
    return std::any_of(scenario.faults.begin(), scenario.faults.end(), [renderer](const Fault& fault) {
        return fault_traits(fault.kind).needs_tmds() && static_cast<std::size_t>(fault.renderer) == renderer;
    });
}

bool disturbs_characters(const Scenario& scenario) {
    return std::any_of(scenario.faults.begin(), scenario.faults.end(),
                       [](const Fault& fault) { return fault_traits(fault.kind).needs_tmds(); });
}

void refuse_faults_of_level_rtl(const Scenario& scenario, const std::string& level) {
    for (std::size_t i = 0; i < scenario.faults.size(); ++i) {
        const Fault& fault = scenario.faults[i];
        if (!fault_traits(fault.kind).only_at_level_rtl()) continue;
        std::string message = fault.where.empty() ? "faults[" : fault.where;
        if (fault.where.empty()) message.append(std::to_string(i)).append("]");
        message.append(".kind: ").append(to_string(fault.kind));
        message.append(" happens clock by clock, which level ").append(level);
        throw InputError(text::one_line(message + " does not know; use --level rtl"));
    }
}

}  // namespace metabuffer
