#include "rtl/bus_arbiter.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "datapath/arbitration/arbitration_table.h"
#include "support/scenarios.h"
#include "support/scratch_directory.h"

// The arbiter has no clock and no ports of its own: it answers within the input framebuffer's clock. The
// policies are tested against independent code in the datapath's unit tests; here, that the block runs the
// one asked for.
namespace metabuffer::test {
namespace {

using rtl::BusArbiter;
using Kind = BusGrant::Kind;

/// A: a row of 30 pixels at multiple 1, needed late. B: 10 pixels, needed first. C: 10 pixels in between.
std::vector<Segment> three_segments() {
    const Size raster{64, 64};
    return {Segment(table_row(1, {0, 0}, {30, 1}, {0, 50}), raster.width, raster.height),
            Segment(table_row(2, {0, 0}, {10, 1}, {0, 0}), raster.width, raster.height),
            Segment(table_row(3, {0, 0}, {10, 1}, {0, 20}), raster.width, raster.height)};
}

std::vector<BusRequest> requests(bool a, bool b, bool c) {
    std::vector<BusRequest> list(3);
    for (BusRequest& request : list) request.pending = true;
    list[0].ready = a;
    list[1].ready = b;
    list[2].ready = c;
    return list;
}

std::vector<int> grants(BusArbiter& arbiter, int count, const std::vector<BusRequest>& wanted) {
    std::vector<int> rows;
    for (int i = 0; i < count; ++i) {
        const BusGrant grant = arbiter.pick(wanted);
        rows.push_back(grant.kind == Kind::kBurst ? grant.row : -1);
    }
    return rows;
}

int count_of(const std::vector<int>& rows, int row) {
    return static_cast<int>(std::count(rows.begin(), rows.end(), row));
}

TEST_CASE("bus arbiter: irsa gives slots in proportion to need and recovers idle ones at once") {
    BusArbiter arbiter("arbiter", Arbitration::kIrsa);
    arbiter.start_frame(three_segments());
    const auto all = grants(arbiter, 50, requests(true, true, true));
    CHECK(count_of(all, 0) == 30);
    CHECK(count_of(all, 1) == 10);
    CHECK(count_of(all, 2) == 10);
    CHECK(count_of(grants(arbiter, 50, requests(false, true, false)), 1) == 50);
}

TEST_CASE("bus arbiter: slot-allocation has the same table and loses idle slots") {
    BusArbiter arbiter("arbiter", Arbitration::kSlotAllocation);
    arbiter.start_frame(three_segments());
    CHECK(count_of(grants(arbiter, 50, requests(true, true, true)), 0) == 30);
    const auto idle = grants(arbiter, 50, requests(false, true, false));
    CHECK(count_of(idle, 1) == 10);
    CHECK(count_of(idle, -1) == 40);
    CHECK(arbiter.pick(requests(false, false, false)).kind == Kind::kLost);
}

TEST_CASE("bus arbiter: round-robin gives one slot each whatever the need, with recovery") {
    BusArbiter arbiter("arbiter", Arbitration::kRoundRobin);
    arbiter.start_frame(three_segments());
    CHECK(grants(arbiter, 6, requests(true, true, true)) == std::vector<int>{0, 1, 2, 0, 1, 2});
    CHECK(grants(arbiter, 4, requests(true, false, true)) == std::vector<int>{0, 2, 0, 2});
}

TEST_CASE("bus arbiter: edf serves the composer that runs dry first") {
    BusArbiter arbiter("arbiter", Arbitration::kEdf);
    arbiter.start_frame(three_segments());
    CHECK(arbiter.pick(requests(true, true, true)).row == 1);
    CHECK(arbiter.pick(requests(true, false, true)).row == 2);
    CHECK(arbiter.pick(requests(true, false, false)).row == 0);
}

TEST_CASE("bus arbiter: with nobody ready the bus polls under every policy with recovery") {
    for (const ArbitrationRow& policy : kArbitrationTable) {
        if (policy.idle_slots == IdleSlots::kLost) continue;
        BusArbiter arbiter(sc_core::sc_gen_unique_name("arbiter"), policy.value);
        arbiter.start_frame(three_segments());
        CHECK(arbiter.pick(requests(false, false, false)).kind == Kind::kPoll);
    }
}

TEST_CASE("bus arbiter: a new frame starts its own table from the first slot") {
    BusArbiter arbiter("arbiter", Arbitration::kRoundRobin);
    arbiter.start_frame(three_segments());
    CHECK(grants(arbiter, 2, requests(true, true, true)) == std::vector<int>{0, 1});
    arbiter.start_frame({three_segments()[2], three_segments()[0]});
    std::vector<BusRequest> two(2);
    for (BusRequest& request : two) request.pending = request.ready = true;
    CHECK(grants(arbiter, 3, two) == std::vector<int>{0, 1, 0});
}

/// The values that a waveform shows of one of the arbiter's registers, in order, repetitions left out.
std::vector<int> waveform_values(const std::filesystem::path& file, const std::string& name) {
    std::ifstream stream(file);
    std::string code;
    std::vector<int> values;
    for (std::string line; std::getline(stream, line);) {
        std::istringstream words(line);
        std::string first;
        std::string second;
        words >> first >> second;
        if (first == "$var" && line.find(' ' + name + ' ') != std::string::npos) {
            words >> code >> code;  // behind the width
        } else if (!code.empty() && second == code && first.front() == 'b') {
            const int value = static_cast<int>(std::stoll(first.substr(1), nullptr, 2));
            if (values.empty() || values.back() != value) values.push_back(value);
        }
    }
    return values;
}

TEST_CASE("bus arbiter: the waveform shows the slot and the row that was granted last") {
    const ScratchDirectory scratch;
    BusArbiter arbiter("arbiter", Arbitration::kSlotAllocation);
    sc_core::sc_trace_file* const file = sc_core::sc_create_vcd_trace_file((scratch / "arbiter").c_str());
    file->set_time_unit(1.0, sc_core::SC_PS);
    arbiter.trace(file);
    const sc_core::sc_time clock(10, sc_core::SC_NS);
    const auto two_rows = [] {
        const Size raster{64, 64};
        return std::vector<Segment>{
            Segment(table_row(1, {0, 0}, {10, 1}, {0, 50}), raster.width, raster.height),
            Segment(table_row(2, {0, 0}, {20, 1}, {0, 0}), raster.width, raster.height)};
    };
    std::vector<BusRequest> both(2);
    for (BusRequest& request : both) request.pending = request.ready = true;
    std::vector<BusRequest> none(2);

    arbiter.start_frame(two_rows());  // slots: row 1, row 0, row 1
    sc_core::sc_start(clock);
    arbiter.pick(both);  // slot 0, row 1
    sc_core::sc_start(clock);
    arbiter.pick(both);  // slot 1, row 0
    sc_core::sc_start(clock);
    arbiter.pick(none);  // slot 2 is lost, nothing is granted
    sc_core::sc_start(clock);
    arbiter.pick(none);  // back at slot 0
    sc_core::sc_start(clock);
    arbiter.start_frame(two_rows());
    sc_core::sc_start(clock);
    sc_core::sc_close_vcd_trace_file(file);

    CHECK(waveform_values(scratch / "arbiter.vcd", "slot") == std::vector<int>{0, 1, 2, 0, 1, 0});
    CHECK(waveform_values(scratch / "arbiter.vcd", "granted_row") == std::vector<int>{-1, 1, 0, -1});
}

}  // namespace
}  // namespace metabuffer::test
