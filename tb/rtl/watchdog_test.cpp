#include "rtl/watchdog.h"

#include <catch2/catch.hpp>
#include <vector>

namespace metabuffer::test::watchdog_test {
namespace {

using rtl::Watchdog;
using sc_core::sc_time;

const sc_time kInterval(100, sc_core::SC_NS);

/// A watchdog over a progress count that changes at given times (in ns), and the times at which it tripped.
class WatchdogBench : public sc_core::sc_module {
  public:
    WatchdogBench(const sc_core::sc_module_name& name, std::vector<int> progress_at_ns)
        : sc_core::sc_module(name),
          progress_at_ns_(std::move(progress_at_ns)),
          watchdog_(
              "watchdog", kInterval,
              [this] {
                  ++checks;
                  return progress_;
              },
              [this] {
                  tripped_at_ns.push_back(
                      static_cast<int>(sc_core::sc_time_stamp().to_seconds() * 1e9 + 0.5));
              }) {
        SC_METHOD(make_progress);
    }
    SC_HAS_PROCESS(WatchdogBench);

    std::vector<int> tripped_at_ns;
    int checks = 0;

  private:
    void make_progress() {
        if (sc_core::sc_time_stamp() > sc_core::SC_ZERO_TIME) ++progress_;
        if (next_ < progress_at_ns_.size()) {
            next_trigger(sc_time(progress_at_ns_[next_++], sc_core::SC_NS) - sc_core::sc_time_stamp());
        }
    }

    std::vector<int> progress_at_ns_;
    std::size_t next_ = 0;
    std::int64_t progress_ = 0;
    Watchdog watchdog_;
};

TEST_CASE("watchdog: trips at the first check that finds no progress since the check before, and only once") {
    WatchdogBench never("never", {});
    WatchdogBench until_250("until_250", {50, 150, 250});
    WatchdogBench just_in_time("just_in_time", {99, 199, 299, 399, 499, 599, 699, 799, 899, 999});
    sc_core::sc_start(sc_time(1050, sc_core::SC_NS));
    CHECK(never.tripped_at_ns == std::vector<int>{100});
    CHECK(until_250.tripped_at_ns == std::vector<int>{400});
    CHECK(just_in_time.tripped_at_ns.empty());
}

TEST_CASE("watchdog: checks once an interval and no more") {
    WatchdogBench bench("bench", {50, 150, 250, 350, 450});
    sc_core::sc_start(sc_time(499, sc_core::SC_NS));
    CHECK(bench.checks == 5);  // at 0, 100, 200, 300 and 400 ns
}

TEST_CASE("watchdog: a count that goes down is progress too") {
    std::int64_t progress = 5;
    bool tripped = false;
    Watchdog watchdog(
        "watchdog", kInterval, [&] { return --progress; }, [&] { tripped = true; });
    sc_core::sc_start(sc_time(1000, sc_core::SC_NS));
    CHECK_FALSE(tripped);
}

TEST_CASE("watchdog: a count that stands at -1 from the beginning trips it like any other") {
    bool tripped = false;
    Watchdog watchdog(
        "watchdog", kInterval, [] { return std::int64_t{-1}; }, [&] { tripped = true; });
    sc_core::sc_start(sc_time(99, sc_core::SC_NS));
    CHECK_FALSE(tripped);
    sc_core::sc_start(sc_time(2, sc_core::SC_NS));
    CHECK(tripped);
}

}  // namespace
}  // namespace metabuffer::test::watchdog_test
