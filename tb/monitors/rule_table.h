#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <systemc>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "monitors/violation.h"

namespace metabuffer::test {

/// Of a violation whose clock follows from nothing that the test knows.
constexpr std::int64_t kAnyClock = std::numeric_limits<std::int64_t>::min();

/// A violation that a row of a table expects.
struct Reported {
    std::string rule;
    std::string signal = {};
    std::int64_t clock = 0;  ///< counted from the bench's clock_zero() on
    std::int64_t frame = -1;
    std::string clock_name = "core";

    std::string to_string() const {
        return rule + ": " + signal + ", " + clock_name + " clock " + std::to_string(clock) + ", frame " +
               std::to_string(frame) + "\n";
    }
};

/// Stands last in a row whose mistake leads to one or more further violations, which the row does not list.
inline const Reported kOthers{"others"};

/// A monitor, the wires that it watches, and what it reports.
class RuleBench : public sc_core::sc_module {
  public:
    explicit RuleBench(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
        log.on_violation([this](const monitors::Violation& violation) { violations.push_back(violation); });
    }
    /// The cycle from which a row's clocks count.
    virtual std::int64_t clock_zero() const = 0;

    monitors::ViolationLog log;
    std::vector<monitors::Violation> violations;
};

/// The rules of a monitor in a table. A row is one way to break a rule in a run that keeps all others, or a run that keeps
/// all rules. Each row has a bench of its own; all of them run side by side.
template <typename Bench>
class RuleTable {
  public:
    /// The benches of the rows from here on are made with these arguments.
    template <typename... Args>
    void of(const Args&... args) {
        make_ = [args...](const char* name) { return std::make_unique<Bench>(name, args...); };
    }
    /// reports: what the monitor reports, in this order and nothing else. change: what is changed before the run. then:
    /// checks more after the run.
    void row(const std::string& name, const std::vector<Reported>& reports,
             const std::function<void(Bench&)>& change = {},
             const std::function<void(const Bench&)>& then = {}) {
        std::string object = name;
        std::replace_if(
            object.begin(), object.end(), [](char c) { return std::isalnum(c) == 0; }, '_');
        rows_.push_back({name, reports, then, make_(object.c_str())});
        if (change) change(*rows_.back().bench);
    }
    /// After the run.
    void check() const {
        for (const Row& row : rows_) row.check();
    }

  private:
    struct Row {
        std::string name;
        std::vector<Reported> reports;
        std::function<void(const Bench&)> then;
        std::unique_ptr<Bench> bench;

        void check() const {
            const bool others = !reports.empty() && reports.back().rule == kOthers.rule;
            const std::size_t listed = reports.size() - (others ? 1 : 0);
            std::string wanted;
            for (const Reported& report : reports) wanted += report.to_string();
            std::string found;
            std::string text;
            std::size_t count = 0;
            for (const monitors::Violation& violation : bench->violations) {
                text += to_string(violation) + "\n";
                const std::size_t index = count++;
                if (others && index >= listed) continue;
                const bool any = index < listed && reports[index].clock == kAnyClock;
                found += Reported{violation.rule, violation.signal,
                                  any ? kAnyClock : violation.cycle - bench->clock_zero(), violation.frame,
                                  violation.clock}
                             .to_string();
                if (violation.detail.empty()) found += "which has no detail\n";
            }
            if (others && count > listed) found += kOthers.to_string();
            INFO("row: " << name);
            INFO(text);
            CHECK(found == wanted);
            if (then) then(*bench);
        }
    };

    std::function<std::unique_ptr<Bench>(const char*)> make_;
    std::vector<Row> rows_;
};

/// A bench whose wires the test writes, by the clocks of a testbench that all rows share.
class ClockedRuleBench : public RuleBench {
  public:
    ClockedRuleBench(const sc_core::sc_module_name& name, ClockedTestbench& testbench)
        : RuleBench(name), bench(testbench) {}
    std::int64_t clock_zero() const override { return bench.core.reset_clocks(); }

    ClockedTestbench& bench;
};

template <typename Bench>
class ClockedRuleTable : public RuleTable<Bench> {
  public:
    template <typename... Args>
    void of(const Args&... args) {
        RuleTable<Bench>::of(std::ref(clocks_), args...);
    }
    void run_and_check(int last_clock) {
        clocks_.run_through(last_clock);
        this->check();
    }

  private:
    ClockedTestbench clocks_;
};

}  // namespace metabuffer::test
