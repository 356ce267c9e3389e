#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/object_key.h"
#include "scenario/scenario.h"

/// The keys of faults; fault_kinds.h has which of them go with which kind.
namespace metabuffer {

/// A key of a fault besides `kind` and `renderer`.
struct FaultKey : ObjectKey<Fault> {
    /// "pair": without the list before it.
    const char* name() const;
};

/// A key as a kind of fault has it.
struct FaultKeyUse {
    const FaultKey* key = nullptr;
    ValueRule rule;  ///< for this kind
    bool required = false;
};

/// Every key, in the order in which files have them.
const std::vector<FaultKey>& fault_keys();

/// The keys that a fault of that kind has, in the same order.
const std::vector<FaultKeyUse>& fault_keys_of(FaultKind kind);
/// The key among them; null if it does not go with the kind.
const FaultKeyUse* use_of(const FaultKey& key, FaultKind kind);

/// "does not go with kind crc; use it with kind delay only": for a key that is given with the wrong kind.
std::string misplaced_fault_key(const FaultKey& key, FaultKind kind);

/// Whether it is a fault of a renderer's link, not one inside the machine.
bool is_on_link(FaultKind kind);

/// Whether a fault of the scenario is in the characters of a renderer's link (index, from 0).
bool disturbs_characters(const Scenario& scenario, std::size_t renderer);
/// The same for any link.
bool disturbs_characters(const Scenario& scenario);

/// Throws InputError if the scenario has a fault that level `level` cannot show, since that level does not simulate
/// each clock. The error names the fault, with file and line if it is from a file.
void refuse_faults_of_level_rtl(const Scenario& scenario, const std::string& level);

}  // namespace metabuffer
