#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/limits.h"
#include "scenario/scenario.h"

/// Which keys a fault of each kind has: the one table that reader, rules and writer go by.
namespace metabuffer {

/// A key of a fault beside `renderer` and `kind`, which all have, and where a Fault keeps its value.
struct FaultKey {
    enum class Shape : std::uint8_t {
        kWholeNumber,
        kFrame,  ///< a FrameKind by its name
        kBeats,  ///< a LostBeats by its name
    };
    const char* name = nullptr;
    Shape shape = Shape::kWholeNumber;
    IntegerRange range;  ///< over all kinds
    std::optional<std::int64_t> (*value)(const Fault&) = nullptr;
    void (*set)(Fault&, std::int64_t) = nullptr;
};

/// A key as a kind of fault has it.
struct FaultKeyUse {
    const FaultKey* key = nullptr;
    bool required = false;
    IntegerRange range;  ///< for this kind
};

/// Every key, in the order in which files have them.
const std::vector<FaultKey>& fault_keys();
/// The key of that name, or null.
const FaultKey* find_fault_key(std::string_view name);

/// The keys that a fault of that kind has, in the same order.
const std::vector<FaultKeyUse>& fault_keys_of(FaultKind kind);

/// "does not go with kind crc; use it with kind delay only": what is told of a key that stands at the wrong kind.
std::string misplaced_fault_key(const FaultKey& key, FaultKind kind);

/// Faults of a renderer's link, as against those inside the machine.
bool is_on_link(FaultKind kind);

/// Faults that happen clock by clock, which level rtl alone has.
bool is_only_at_level_rtl(FaultKind kind);

/// Throws InputError, which names the fault by its place in the file if it is from one, if the scenario has a
/// fault that level `level`, which knows no clock by clock, cannot show.
void refuse_faults_of_level_rtl(const Scenario& scenario, const std::string& level);

}  // namespace metabuffer
