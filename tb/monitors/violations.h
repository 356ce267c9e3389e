#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "monitors/violation.h"

namespace metabuffer::test {

/// Collects what a monitor reports. Clocks are the testbench's, which count from the end of reset.
struct Violations {
    monitors::ViolationLog log;
    std::vector<monitors::Violation> list;

    explicit Violations(const ClockDomain& core) : core_(core) {
        log.on_violation([this](const monitors::Violation& violation) { list.push_back(violation); });
    }

    std::string text() const {
        std::string lines;
        for (const monitors::Violation& violation : list) lines += to_string(violation) + "\n";
        return lines;
    }
    /// The first violation is this one.
    void check_first(const std::string& rule, const std::string& signal, int clock, int frame) const {
        INFO(text());
        REQUIRE_FALSE(list.empty());
        CHECK(list[0].rule == rule);
        CHECK(list[0].signal == signal);
        CHECK(list[0].clock == "core");
        CHECK(list[0].cycle - core_.reset_clocks() == clock);
        CHECK(list[0].frame == frame);
        CHECK_FALSE(list[0].detail.empty());
    }
    /// There is this violation and no other.
    void check_only(const std::string& rule, const std::string& signal, int clock, int frame) const {
        check_first(rule, signal, clock, frame);
        INFO(text());
        CHECK(list.size() == 1);
    }
    void check_none() const {
        INFO(text());
        CHECK(list.empty());
    }

  private:
    const ClockDomain& core_;
};

}  // namespace metabuffer::test
