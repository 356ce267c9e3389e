#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenario/scenario.h"

namespace metabuffer::test {

/// A scenario and the seed that it was made of.
struct SoakMachine {
    std::uint64_t seed = 0;
    Scenario scenario;
};

/// What is wrong with a machine. Two machines fail in the same kind if `kind` is equal.
struct SoakVerdict {
    std::string
        kind;  ///< "identical": nothing; "different", "check", "violation RULE", "error", "crash", "hang"
    std::string text;  ///< a line for each thing that is wrong

    bool good() const { return kind == kGood; }
    static constexpr const char* kGood = "identical";
};

/// Runs machines side by side at level rtl, under every check and monitor, and at level tlm, with which it must agree,
/// unless the scenario has faults that level tlm does not know. Elaborates, so a process can do this once. Lets
/// errors of the model through: they end all machines.
std::vector<SoakVerdict> judge_machines(const std::vector<SoakMachine>& machines);

/// The same for one machine: an error of the model is a verdict, too.
SoakVerdict judge_machine(const SoakMachine& machine);

/// The same in a separate process, which may crash, and may take so long. This process must not have elaborated.
SoakVerdict judge_in_child(const SoakMachine& machine, int most_seconds);

}  // namespace metabuffer::test
