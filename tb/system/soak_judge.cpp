#define CATCH_CONFIG_EXTERNAL_INTERFACES
#include "soak_judge.h"

#include <poll.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <exception>
#include <functional>
#include <iostream>
#include <memory>
#include <sstream>
#include <string_view>
#include <systemc>
#include <utility>

#include "host/child_process.h"
#include "machine_checks.h"
#include "machine_run.h"
#include "random_scenario.h"
#include "scenario/fault_keys.h"
#include "test_session.h"
#include "tlm_run.h"

namespace metabuffer::test {
namespace {

// How the reporter writes what a test case has found: a line that names the kind, then indented lines.
constexpr std::string_view kVerdict = "verdict ";
constexpr std::string_view kIndent = "  ";
constexpr const char* kDifferent = "different";
constexpr const char* kCheck = "check";

/// What the checks of one machine have found. The checks are those of the tests, which report to Catch. So each machine
/// is a test case, and this is the reporter of its run.
class VerdictReporter final : public Catch::StreamingReporterBase<VerdictReporter> {
  public:
    using StreamingReporterBase::StreamingReporterBase;
    static std::string getDescription() { return "verdicts on machines, for soak_machines"; }

    void assertionStarting(const Catch::AssertionInfo& /*info*/) override {}
    bool assertionEnded(const Catch::AssertionStats& stats) override {
        const Catch::AssertionResult& result = stats.assertionResult;
        if (result.isOk()) return true;
        const bool level_difference = result.getResultType() == Catch::ResultWas::ExplicitFailure;
        kind_ = level_difference ? kDifferent : kind_.empty() ? kCheck : kind_;
        std::ostringstream line;
        if (level_difference) {
            line << result.getMessage();
        } else {
            line << result.getExpressionInMacro() << " is " << result.getExpandedExpression() << " ("
                 << result.getSourceInfo().file << ":" << result.getSourceInfo().line << ")";
            for (const Catch::MessageInfo& message : stats.infoMessages) line << ", " << message.message;
            if (result.hasMessage()) line << ", " << result.getMessage();
        }
        lines_ += indented(line.str());
        return true;
    }
    void testCaseEnded(const Catch::TestCaseStats& stats) override {
        stream << kVerdict << (kind_.empty() ? SoakVerdict::kGood : kind_) << '\n' << lines_;
        kind_.clear();
        lines_.clear();
        StreamingReporterBase::testCaseEnded(stats);
    }

  private:
    static std::string indented(const std::string& text) {
        std::string result;
        std::istringstream in(text);
        for (std::string line; std::getline(in, line);) result += std::string(kIndent) + line + '\n';
        return result;
    }

    std::string kind_;
    std::string lines_;
};
CATCH_REGISTER_REPORTER("verdicts", VerdictReporter)

/// A test case that is a call.
class Call final : public Catch::ITestInvoker {
  public:
    explicit Call(std::function<void()> call) : call_(std::move(call)) {}
    void invoke() const override { call_(); }

  private:
    std::function<void()> call_;
};

/// One machine at the levels that it can run at.
struct Levels {
    std::unique_ptr<TlmRun> tlm;
    std::unique_ptr<TlmRun> counters_only;
};

bool level_tlm_knows(const Scenario& scenario) {
    return std::none_of(scenario.faults.begin(), scenario.faults.end(),
                        [](const Fault& fault) { return fault_traits(fault.kind).only_at_level_rtl(); });
}

void check_machine(const MachineRun& rtl, const Levels& levels) {
    std::vector<std::string> differences;
    for (const auto& tlm : {levels.tlm.get(), levels.counters_only.get()}) {
        if (tlm == nullptr) continue;
        for (std::string& line : level_differences(rtl, *tlm)) differences.push_back(std::move(line));
    }
    if (!differences.empty()) FAIL_CHECK(first_lines(differences));
    CHECK(rtl.finished());
    if (rtl.finished()) check_run(rtl);
}

/// What the reporter has written, one verdict for each test case.
std::vector<SoakVerdict> parsed(const std::string& output) {
    std::vector<SoakVerdict> verdicts;
    std::istringstream in(output);
    for (std::string line; std::getline(in, line);) {
        if (line.substr(0, kVerdict.size()) == kVerdict) {
            verdicts.push_back({line.substr(kVerdict.size()), {}});
        } else if (!verdicts.empty() && line.substr(0, kIndent.size()) == kIndent) {
            verdicts.back().text += line.substr(kIndent.size()) + '\n';
        }
    }
    return verdicts;
}

/// Runs Catch; returns what standard output would get.
std::string session_output() {
    std::ostringstream output;
    std::streambuf* const before = std::cout.rdbuf(output.rdbuf());
    const std::vector<const char*> words{"soak_machines", "--reporter", "verdicts",
                                         "--order",       "decl",       "[soak]"};
    test::run_session(static_cast<int>(words.size()), words.data());
    std::cout.rdbuf(before);
    return output.str();
}

/// The kind of an error that the model has reported: a monitor's names its rule.
std::string kind_of(const sc_core::sc_report& report) {
    constexpr std::string_view kMonitor = "/metabuffer/monitor/";
    const std::string_view type = report.get_msg_type();
    if (type.substr(0, kMonitor.size()) != kMonitor) return "error";
    return "violation " + std::string(type.substr(kMonitor.size()));
}

}  // namespace

std::vector<SoakVerdict> judge_machines(const std::vector<SoakMachine>& machines) {
    MachineRuns rtl;
    std::vector<Levels> levels(machines.size());
    for (std::size_t i = 0; i < machines.size(); ++i) {
        const std::string name = "machine_" + std::to_string(machines[i].seed);
        rtl.push_back(std::make_unique<MachineRun>(name + "_rtl", machines[i].scenario));
        if (!level_tlm_knows(machines[i].scenario)) continue;
        levels[i].tlm = std::make_unique<TlmRun>(name + "_tlm", machines[i].scenario);
        levels[i].counters_only = std::make_unique<TlmRun>(name + "_counters", machines[i].scenario, false);
    }
    run_to_end(rtl);
    simulate_until([&levels] {
        return std::all_of(levels.begin(), levels.end(), [](const Levels& level) {
            return level.tlm == nullptr || (level.tlm->finished() && level.counters_only->finished());
        });
    });
    for (std::size_t i = 0; i < machines.size(); ++i) {
        // Registers in its constructor, as the macro does for a function.
        const Catch::AutoReg registration(new Call([&rtl, &levels, i] { check_machine(*rtl[i], levels[i]); }),
                                          CATCH_INTERNAL_LINEINFO, Catch::StringRef(),
                                          Catch::NameAndTags{"machine " + std::to_string(i), "[soak]"});
    }
    return parsed(session_output());
}

SoakVerdict judge_machine(const SoakMachine& machine) {
    try {
        const std::vector<SoakVerdict> verdicts = judge_machines({machine});
        return verdicts.size() == 1 ? verdicts.front() : SoakVerdict{"error", "the checks gave no verdict\n"};
    } catch (const sc_core::sc_report& report) {
        return {kind_of(report), report.what() + std::string("\n")};
    } catch (const std::exception& error) {
        return {"error", error.what() + std::string("\n")};
    }
}

SoakVerdict judge_in_child(const SoakMachine& machine, int most_seconds) {
    ChildProcess child([&machine](const ChildProcess::Sender& sender) {
        const SoakVerdict verdict = judge_machine(machine);
        const std::string text = verdict.kind + '\n' + verdict.text;
        sender.send(text.data(), text.size());
    });
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::seconds(most_seconds);
    std::string text;
    while (!child.ended()) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
        pollfd descriptor{child.descriptor(), POLLIN, 0};
        const int ready = left > 0 ? poll(&descriptor, 1, static_cast<int>(left)) : 0;
        if (ready < 0 && errno == EINTR) continue;
        if (ready <= 0) return {"hang", "still running after " + std::to_string(most_seconds) + " s\n"};
        child.receive(text);
    }
    if (!child.complaint().empty()) return {"crash", child.complaint() + '\n' + text};
    const std::size_t line = std::min(text.find('\n'), text.size());
    return {text.substr(0, line), text.substr(std::min(line + 1, text.size()))};
}

}  // namespace metabuffer::test
