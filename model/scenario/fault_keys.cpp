#include "scenario/fault_keys.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <type_traits>

#include "host/errors.h"
#include "host/text.h"
#include "scenario/names.h"

namespace metabuffer {
namespace {

/// A key whose value is a member of a Fault.
template <auto Member>
FaultKey number_key(const char* name, const IntegerRange& range) {
    return {name, FaultKey::Shape::kWholeNumber, range,
            [](const Fault& fault) {
                return std::optional<std::int64_t>(static_cast<std::int64_t>(fault.*Member));
            },
            [](Fault& fault, std::int64_t value) {
                fault.*Member = static_cast<std::decay_t<decltype(fault.*Member)>>(value);
            }};
}

const FaultKey& key_named(std::string_view name) {
    const FaultKey* const key = find_fault_key(name);
    if (key == nullptr) throw std::logic_error("no key of a fault: " + std::string(name));
    return *key;
}

FaultKeyUse required(std::string_view name) {
    const FaultKey& key = key_named(name);
    return {&key, true, key.range};
}

FaultKeyUse required(std::string_view name, const IntegerRange& range) {
    return {&key_named(name), true, range};
}

FaultKeyUse optional(std::string_view name) {
    const FaultKey& key = key_named(name);
    return {&key, false, key.range};
}

using Uses = std::vector<FaultKeyUse>;

/// `more` behind the keys that name a frame on a link.
Uses of_frame(const Uses& more = {}) {
    Uses uses{required("pair"), optional("frame")};
    uses.insert(uses.end(), more.begin(), more.end());
    return uses;
}

std::map<FaultKind, Uses> keys_by_kind() {
    const IntegerRange& byte_bits = limits::kByteBits;
    return {
        {FaultKind::kMagic, of_frame()},
        {FaultKind::kVersion, of_frame()},
        {FaultKind::kKind, of_frame()},
        {FaultKind::kCrc, of_frame()},
        {FaultKind::kNumber, of_frame()},
        {FaultKind::kShortLine, of_frame()},
        {FaultKind::kLongLine, of_frame()},
        {FaultKind::kShortFrame, of_frame({optional("lines")})},
        {FaultKind::kLongFrame, of_frame({optional("lines")})},
        {FaultKind::kMissing, of_frame()},
        {FaultKind::kDelay, of_frame({required("delay_pairs")})},
        {FaultKind::kRepeated, of_frame()},
        {FaultKind::kOtherPair, of_frame()},
        {FaultKind::kControlByte, of_frame({required("byte"), required("bits", byte_bits)})},
        {FaultKind::kPixelBits, of_frame({required("bits"), required("x"), required("y")})},
        {FaultKind::kDrift, {required("pair"), required("ppm")}},
        {FaultKind::kBusreadyLow, {required("display"), optional("from_cycle"), optional("cycles")}},
        {FaultKind::kPipereadyLow, {required("display"), optional("from_cycle"), optional("cycles")}},
        {FaultKind::kLostBeat,
         {required("display"), optional("from_cycle"), optional("beats"), optional("of")}},
        {FaultKind::kRandomStalls,
         {optional("from_cycle"), optional("cycles"), required("percent"), optional("seed")}},
    };
}

std::vector<std::string> kinds_with(const FaultKey& key) {
    std::vector<std::string> names;
    for (const auto& kind : EnumNames<FaultKind>::kTable) {
        const Uses& uses = fault_keys_of(kind.value);
        const bool has_key =
            std::any_of(uses.begin(), uses.end(), [&key](const FaultKeyUse& use) { return use.key == &key; });
        if (has_key) names.emplace_back(kind.name);
    }
    return names;
}

}  // namespace

const std::vector<FaultKey>& fault_keys() {
    static const std::vector<FaultKey> keys{
        number_key<&Fault::pair>("pair", limits::kFaultPair),
        {"frame",
         FaultKey::Shape::kFrame,
         {0, 1},
         [](const Fault& fault) { return std::optional<std::int64_t>(static_cast<int>(fault.frame)); },
         [](Fault& fault, std::int64_t value) { fault.frame = static_cast<FrameKind>(value); }},
        number_key<&Fault::delay_pairs>("delay_pairs", limits::kDelayPairs),
        number_key<&Fault::lines>("lines", limits::kFaultLines),
        number_key<&Fault::byte>("byte", limits::kFaultByte),
        number_key<&Fault::bits>("bits", limits::kLinkPixelBits),
        number_key<&Fault::x>("x", limits::kFaultPosition),
        number_key<&Fault::y>("y", limits::kFaultPosition),
        number_key<&Fault::ppm>("ppm", limits::kFaultPpm),
        number_key<&Fault::display>("display", limits::kFaultDisplay),
        number_key<&Fault::from_cycle>("from_cycle", limits::kFaultFromCycle),
        {"cycles", FaultKey::Shape::kWholeNumber, limits::kFaultCycles,
         [](const Fault& fault) { return fault.cycles; },
         [](Fault& fault, std::int64_t value) { fault.cycles = value; }},
        number_key<&Fault::beats>("beats", limits::kFaultBeats),
        {"of",
         FaultKey::Shape::kBeats,
         {0, static_cast<int>(LostBeats::kAny)},
         [](const Fault& fault) { return std::optional<std::int64_t>(static_cast<int>(fault.of)); },
         [](Fault& fault, std::int64_t value) { fault.of = static_cast<LostBeats>(value); }},
        number_key<&Fault::percent>("percent", limits::kFaultPercent),
        number_key<&Fault::seed>("seed", limits::kFaultSeed),
    };
    return keys;
}

const FaultKey* find_fault_key(std::string_view name) {
    const std::vector<FaultKey>& keys = fault_keys();
    const auto found =
        std::find_if(keys.begin(), keys.end(), [name](const FaultKey& key) { return key.name == name; });
    return found == keys.end() ? nullptr : &*found;
}

const std::vector<FaultKeyUse>& fault_keys_of(FaultKind kind) {
    static const std::map<FaultKind, Uses> uses = keys_by_kind();
    return uses.at(kind);
}

std::string misplaced_fault_key(const FaultKey& key, FaultKind kind) {
    constexpr std::size_t kFewKinds = 4;
    const std::string text = std::string("does not go with kind ") + to_string(kind) + "; ";
    const std::vector<std::string> kinds = kinds_with(key);
    if (kinds.size() <= kFewKinds) {
        return text + "use it with kind " + text::joined(kinds, "or") + " only";
    }
    std::vector<std::string> keys{"renderer", "kind"};
    for (const FaultKeyUse& use : fault_keys_of(kind)) keys.emplace_back(use.key->name);
    return text + "its keys are " + text::joined(keys, "and");
}

bool is_on_link(FaultKind kind) { return kind == FaultKind::kDrift || !is_only_at_level_rtl(kind); }

bool is_only_at_level_rtl(FaultKind kind) {
    switch (kind) {
        case FaultKind::kDrift:
        case FaultKind::kBusreadyLow:
        case FaultKind::kPipereadyLow:
        case FaultKind::kLostBeat:
        case FaultKind::kRandomStalls:
            return true;
        default:
            return false;
    }
}

void refuse_faults_of_level_rtl(const Scenario& scenario, const std::string& level) {
    for (std::size_t i = 0; i < scenario.faults.size(); ++i) {
        const Fault& fault = scenario.faults[i];
        if (!is_only_at_level_rtl(fault.kind)) continue;
        std::string message = fault.where.empty() ? "faults[" : fault.where;
        if (fault.where.empty()) message.append(std::to_string(i)).append("]");
        message.append(".kind: ").append(to_string(fault.kind));
        message.append(" happens clock by clock, which level ").append(level);
        throw InputError(text::one_line(message + " does not know; use --level rtl"));
    }
}

}  // namespace metabuffer
