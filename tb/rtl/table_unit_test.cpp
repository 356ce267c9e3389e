#include "rtl/table_unit.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "datapath/arbitration/arbitration_table.h"
#include "formats/slot_payload.h"
#include "support/random_seed.h"
#include "support/rows.h"
#include "support/traced_values.h"

namespace metabuffer::test::table_unit_test {
namespace {

using rtl::DecoderEvent;
using rtl::FrontTable;
using rtl::TableUnit;

ViewportLimits limits() {
    ViewportLimits limits;
    limits.displays = 4;
    limits.image_width_pixels = 64;
    limits.image_height_pixels = 48;
    limits.raster_width_pixels = 64;
    limits.raster_height_pixels = 48;
    limits.buffer_pixels = 1024;
    limits.ready_space_pixels = 16;
    return limits;
}

BusConfig bus_of(Arbitration arbitration, SlotTableMaker maker) {
    BusConfig bus;
    bus.arbitration = arbitration;
    bus.slot_table = maker;
    return bus;
}

struct TableBench {
    ClockDomain& core;
    sc_core::sc_signal<DecoderEvent> event;
    sc_core::sc_signal<bool> front;
    sc_core::sc_signal<FrontTable> table;
    TableUnit dut;
    const Recording<FrontTable>& tables;

    explicit TableBench(ClockedTestbench& bench, Arbitration arbitration = Arbitration::kIrsa,
                        SlotTableMaker maker = SlotTableMaker::kBuilt)
        : core(bench.core),
          dut("table_unit", bus_of(arbitration, maker), limits()),
          tables(core.record_sampled(table)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.event_i(event);
        dut.front_i(front);
        dut.table_o(table);
        bench.trace(dut);
    }
    /// A colour frame begins at edge `clock`, and its rows come one a clock from the next edge on. Returns the clock
    /// after.
    int give(int clock, const ViewportTable& rows) {
        DecoderEvent start;
        start.colour_start = true;
        core.drive(event, clock++, start);
        for (const ViewportRow& row : rows) {
            DecoderEvent with_row;
            with_row.row = true;
            with_row.table_row = row;
            core.drive(event, clock++, with_row);
        }
        core.drive(event, clock, DecoderEvent{});
        return clock;
    }
    /// The payload of a depth frame's control scanline, from edge `clock` on. Returns the clock after.
    int give_payload(int clock, const std::vector<std::uint8_t>& payload) {
        for (std::size_t byte = 0; byte < payload.size(); byte += kLinkBytesPerPixel, ++clock) {
            DecoderEvent event_now;
            while (event_now.payload_bytes < kLinkBytesPerPixel &&
                   byte + event_now.payload_bytes < payload.size()) {
                event_now.payload[event_now.payload_bytes] = payload[byte + event_now.payload_bytes];
                ++event_now.payload_bytes;
            }
            core.drive(event, clock, event_now);
        }
        core.drive(event, clock, DecoderEvent{});
        return clock;
    }
};

ViewportTable two_rows() {
    return {table_row(2, {0, 0}, {30, 2}, {0, 0}), table_row(1, {0, 0}, {10, 2}, {0, 0})};
}
ViewportTable one_row() { return {table_row(4, {5, 5}, {8, 8}, {3, 3})}; }

TEST_CASE("table unit: the back device's rows show when the devices swap, and stand until they swap again") {
    ClockedTestbench bench;
    TableBench dut(bench);
    dut.give(2, two_rows());
    dut.core.drive(dut.front, 20, true);
    dut.give(24, one_row());
    dut.core.drive(dut.front, 40, false);
    bench.run_through(50);
    for (int clock = 0; clock < 20; ++clock) CHECK(dut.tables.at(clock).rows.empty());
    for (int clock = 20; clock < 40; ++clock) CHECK(dut.tables.at(clock).rows == two_rows());
    for (int clock = 40; clock < 50; ++clock) CHECK(dut.tables.at(clock).rows == one_row());
}

TEST_CASE("table unit: a row that breaks a rule is left out, and the slot table is that of the valid rows") {
    ClockedTestbench bench;
    TableBench dut(bench);
    ViewportTable rows = two_rows();
    rows.insert(rows.begin(), table_row(5, {0, 0}, {10, 10}, {0, 0}));      // no such display
    rows.insert(rows.begin() + 2, table_row(2, {0, 0}, {10, 10}, {0, 0}));  // display 2 has a row already
    const int behind = dut.give(2, rows);
    dut.core.drive(dut.front, behind + 2, true);
    bench.run_through(behind);
    CHECK(dut.dut.back_table().rejected.size() == 2);
    CHECK(dut.dut.back_table().rejected.front().index == 0);
    CHECK(dut.dut.back_table().rejected.back().defect == RowDefect::kDuplicate);
    bench.run_through(behind + 5);
    CHECK(dut.tables.at(behind + 3).rows == two_rows());
    CHECK(dut.tables.at(behind + 3).slots == slots_of(Arbitration::kIrsa, two_rows()));
}

TEST_CASE("table unit: rows that are all the same, one a clock, are each judged") {
    ClockedTestbench bench;
    TableBench dut(bench);
    // More rows than the idle clocks after which the clock gate closes.
    const int behind = dut.give(2, ViewportTable(20, one_row().front()));
    bench.run_through(behind);
    CHECK(dut.dut.back_table().rows.size() == 1);
    CHECK(dut.dut.back_table().rejected.size() == 19);
}

TEST_CASE("table unit: a policy without slots has no slot table") {
    ClockedTestbench bench;
    TableBench dut(bench, Arbitration::kEdf);
    dut.give(2, two_rows());
    dut.core.drive(dut.front, 10, true);
    bench.run_through(12);
    CHECK(dut.tables.at(11).rows == two_rows());
    CHECK(dut.tables.at(11).slots.empty());
}

TEST_CASE("table unit: a colour frame that begins again replaces the rows of the one before") {
    ClockedTestbench bench;
    TableBench dut(bench);
    dut.give(2, two_rows());
    dut.give(30, one_row());  // long enough after it for the clock gate to close
    dut.core.drive(dut.front, 50, true);
    bench.run_through(55);
    CHECK(dut.tables.at(51).rows == one_row());
}

/// A reset comes so many clocks after the last row.
void check_reset(int idle_clocks) {
    ClockedTestbench bench;
    TableBench dut(bench);
    dut.give(2, two_rows());
    dut.core.drive(dut.front, 10, true);
    const int behind = dut.give(12, one_row());
    const int reset = behind + idle_clocks;
    bench.core.pulse(bench.reset, reset);
    dut.core.drive(dut.front, reset + 10, false);
    dut.core.drive(dut.front, reset + 12, true);
    bench.run_through(reset + 15);
    CHECK(dut.tables.at(reset - 1).rows == two_rows());
    for (int clock = reset; clock < reset + 15; ++clock) CHECK(dut.tables.at(clock).rows.empty());
}

TEST_CASE("table unit: a reset forgets both tables, whichever device is in front") { check_reset(3); }

TEST_CASE("table unit: a reset wakes a block that sleeps, and it forgets both tables") { check_reset(50); }

/// Rows 0 and 1 of two_rows, as the host numbers them.
const std::vector<int> kHostSlots{1, 0, 0, 1, 0, 0, 0};

TEST_CASE("table unit: the host's slot table is the one that the bus sees") {
    ClockedTestbench bench;
    TableBench dut(bench, Arbitration::kIrsa, SlotTableMaker::kHost);
    dut.give(2, two_rows());
    dut.give_payload(8, encode_slots(kHostSlots, 2));
    bench.run_through(20);
    CHECK_FALSE(dut.dut.back_slots_rejected());
    dut.core.drive(dut.front, 22, true);
    bench.run_through(25);
    CHECK(dut.tables.at(23).rows == two_rows());
    CHECK(dut.tables.at(23).slots == kHostSlots);
}

TEST_CASE(
    "table unit: a waveform has the numbers of rows and bytes of slots that have come, 0 after a reset") {
    ClockedTestbench bench;
    TableBench dut(bench, Arbitration::kIrsa, SlotTableMaker::kHost);
    const std::vector<std::uint8_t> payload = encode_slots(kHostSlots, 2);
    dut.give(2, two_rows());
    dut.give_payload(8, payload);
    bench.core.pulse(bench.reset, 20);
    bench.run_through(18);
    CHECK(traced_values(dut.dut) ==
          std::vector<std::string>{"table_unit.back_rows[3]=2",
                                   "table_unit.back_slot_bytes[16]=" + std::to_string(payload.size())});
    bench.run_through(25);
    CHECK(traced_values(dut.dut) ==
          std::vector<std::string>{"table_unit.back_rows[3]=0", "table_unit.back_slot_bytes[16]=0"});
}

TEST_CASE("table unit: the slots of a table with dropped rows are those of the valid rows") {
    ClockedTestbench bench;
    TableBench dut(bench, Arbitration::kIrsa, SlotTableMaker::kHost);
    ViewportTable rows = two_rows();
    rows.insert(rows.begin(), table_row(5, {0, 0}, {10, 10}, {0, 0}));  // no such display
    dut.give(2, rows);
    dut.give_payload(8, encode_slots({2, 1, 1}, 3));
    dut.core.drive(dut.front, 20, true);
    bench.run_through(25);
    CHECK(dut.tables.at(21).slots == std::vector<int>{1, 0, 0});
}

TEST_CASE("table unit: a slot table that is missing or wrong gives each row a slot") {
    ClockedTestbench bench;
    TableBench dut(bench, Arbitration::kIrsa, SlotTableMaker::kHost);
    const std::vector<std::vector<std::uint8_t>> payloads{
        {},                          // missing
        encode_slots({0, 0, 0}, 2),  // no slot of row 1
        encode_slots({0, 1, 2}, 3),  // a slot of a row that is not there
        {'S', 1, 2},                 // cut short
        {'M', 1, 2, 0, 0b10},        // something else
    };
    int clock = 2;
    bool front = false;
    std::vector<int> shown;
    for (const std::vector<std::uint8_t>& payload : payloads) {
        const int rows_given = dut.give(clock, two_rows());
        const int slots_given = dut.give_payload(rows_given + 1, payload);
        front = !front;
        dut.core.drive(dut.front, slots_given + 2, front);
        shown.push_back(slots_given + 3);
        clock = slots_given + 5;
    }
    bench.run_through(clock + 5);
    for (const int at : shown) {
        INFO("clock " << at);
        CHECK(dut.tables.at(at).rows == two_rows());
        CHECK(dut.tables.at(at).slots == std::vector<int>{0, 1});
    }
}

TEST_CASE(
    "table unit: a missing slot table is reported, and a colour frame drops the slots of the one before") {
    ClockedTestbench bench;
    TableBench dut(bench, Arbitration::kIrsa, SlotTableMaker::kHost);
    dut.give(2, two_rows());
    dut.give_payload(8, encode_slots(kHostSlots, 2));
    bench.run_through(14);
    CHECK_FALSE(dut.dut.back_slots_rejected());
    dut.give(20, two_rows());
    bench.run_through(26);
    CHECK(dut.dut.back_slots_rejected());
}

TEST_CASE("table unit: a policy that uses no slot table of the host does not report it as missing") {
    ClockedTestbench bench;
    TableBench by_deadlines(bench, Arbitration::kEdf, SlotTableMaker::kHost);
    by_deadlines.give(2, two_rows());
    bench.run_through(10);
    CHECK_FALSE(by_deadlines.dut.back_slots_rejected());
}

}  // namespace
}  // namespace metabuffer::test::table_unit_test
