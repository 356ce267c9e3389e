#include "rtl/table_unit.h"

#include <catch2/catch.hpp>
#include <vector>

#include "clocked_testbench.h"
#include "datapath/arbitration/arbitration_table.h"
#include "support/random_seed.h"
#include "support/rows.h"

namespace metabuffer::test {
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

struct TableBench {
    ClockDomain& core;
    sc_core::sc_signal<DecoderEvent> event;
    sc_core::sc_signal<bool> front;
    sc_core::sc_signal<FrontTable> table;
    TableUnit dut;
    const Recording<FrontTable>& tables;

    explicit TableBench(ClockedTestbench& bench, Arbitration arbitration = Arbitration::kIrsa)
        : core(bench.core), dut("table_unit", arbitration, limits()), tables(core.record_sampled(table)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.event_i(event);
        dut.front_i(front);
        dut.table_o(table);
        bench.trace(dut);
    }
    /// A colour frame begins at edge `clock`, and its rows come one a clock from the next edge on. The clock behind.
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
};

ViewportTable two_rows() {
    return {table_row(2, {0, 0}, {30, 2}, {0, 0}), table_row(1, {0, 0}, {10, 2}, {0, 0})};
}
ViewportTable one_row() { return {table_row(4, {5, 5}, {8, 8}, {3, 3})}; }

TEST_CASE(
    "table unit: the back device's rows show when the devices change places, and stand until they do again") {
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

TEST_CASE(
    "table unit: a row that breaks a rule is left out, and the slot table is that of the rows that stand") {
    ClockedTestbench bench;
    TableBench dut(bench);
    ViewportTable rows = two_rows();
    rows.insert(rows.begin(), table_row(5, {0, 0}, {10, 10}, {0, 0}));      // no such display
    rows.insert(rows.begin() + 2, table_row(2, {0, 0}, {10, 10}, {0, 0}));  // taken
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
    // More of them than idle clocks after which the clock gate closes.
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

TEST_CASE("table unit: a colour frame that begins again takes the rows of the one before") {
    ClockedTestbench bench;
    TableBench dut(bench);
    dut.give(2, two_rows());
    dut.give(30, one_row());  // long enough after it for the clock gate to close
    dut.core.drive(dut.front, 50, true);
    bench.run_through(55);
    CHECK(dut.tables.at(51).rows == one_row());
}

TEST_CASE("table unit: a reset forgets both tables, whichever device is in front") {
    ClockedTestbench bench;
    TableBench dut(bench);
    dut.give(2, two_rows());
    dut.core.drive(dut.front, 10, true);
    dut.give(12, one_row());
    bench.core.pulse(bench.reset, 20);
    dut.core.drive(dut.front, 30, false);
    dut.core.drive(dut.front, 32, true);
    bench.run_through(35);
    CHECK(dut.tables.at(19).rows == two_rows());
    for (int clock = 20; clock < 35; ++clock) CHECK(dut.tables.at(clock).rows.empty());
}

}  // namespace
}  // namespace metabuffer::test
