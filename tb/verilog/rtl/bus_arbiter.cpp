// clang-format off
// Before SystemC's headers: with them Verilator's expect its older, global names.
#include "VerilatedBusArbiter.h"

#include "rtl/bus_arbiter.h"
// clang-format on

#include <verilated.h>

#include <limits>
#include <string>
#include <type_traits>

#include "datapath/arbitration/arbitration_table.h"
#include "rtl/register.h"
#include "rtl/wires.h"
#include "scenario/limits.h"

namespace metabuffer::rtl {

namespace {

constexpr int kLines = BUS_ARBITER_LINES;
constexpr int kSlots = BUS_ARBITER_SLOTS;
constexpr int kLineBits = bits_for(kLines - 1);
constexpr int kWordBits = 32;  // of a wide pin's elements
static_assert(kLines >= 3 && kLines <= 64, "the request lines are one integer, the deadlines a wide pin");
static_assert(kSlots >= most_slots(kLines));
static_assert(limits::kGrantCycles.high <= std::numeric_limits<CData>::max());

/// Registers that reset does not set start with random values.
constexpr int kRandomRegisters = 2;

/// Puts a row's number into the packed slot table. It may lie across two elements.
template <typename WidePin>
void put_slot(WidePin& pin, int slot, int row) {
    for (int bit = 0; bit < kLineBits; ++bit) {
        const int position = slot * kLineBits + bit;
        const EData mask = EData{1} << (position % kWordBits);
        EData& element = pin[static_cast<std::size_t>(position / kWordBits)];
        element = ((row >> bit) & 1) != 0 ? element | mask : element & ~mask;
    }
}

}  // namespace

BusArbiter::BusArbiter(const sc_core::sc_module_name& name, const BusConfig& bus, int lines)
    : Block(name),
      pending_i("pending_i", static_cast<std::size_t>(lines)),
      ready_i("ready_i", static_cast<std::size_t>(lines)),
      deadline_i("deadline_i", goes_by_deadlines(bus.arbitration) ? static_cast<std::size_t>(lines) : 0),
      grant_o("grant_o", static_cast<std::size_t>(lines)),
      context_(std::make_unique<VerilatedContext>()) {
    if (lines > kLines) {
        SC_REPORT_ERROR("/metabuffer/bus_arbiter/size",
                        (std::string(this->name()) + ": the scenario has " + std::to_string(lines) +
                         " displays, the verilated bus arbiter request lines for " + std::to_string(kLines) +
                         "; build with -DBUS_ARBITER_LINES=N, N at most 64")
                            .c_str());
    }
    context_->randReset(kRandomRegisters);
    context_->randSeed(lines);
    verilated_ = std::make_unique<VerilatedBusArbiter>(context_.get(), "bus_arbiter");
    verilated_->clk_i = 0;
    verilated_->reset_i = 1;
    verilated_->by_deadline_i = goes_by_deadlines(bus.arbitration) ? 1 : 0;
    verilated_->lose_idle_i = loses_slots(bus.arbitration) ? 1 : 0;
    verilated_->grant_cycles_i = static_cast<CData>(bus.grant_cycles);
    verilated_->build_i = bus.slot_table == SlotTableMaker::kBuilt ? 1 : 0;
    verilated_->eval();
    SC_METHOD(process);
    sensitive << clk_i.pos();
    for (std::size_t line = 0; line < pending_i.size(); ++line) {
        sensitive << pending_i[line] << ready_i[line];
    }
    for (auto& deadline : deadline_i) {
        sensitive << deadline;
    }
    dont_initialize();
}

BusArbiter::~BusArbiter() { verilated_->final(); }

void BusArbiter::process() {
    drive_requests();
    if (clk_i.posedge()) {
        clock_edge();
    } else {
        verilated_->clk_i = 0;
        verilated_->eval();
    }
    drive_outputs();
}

void BusArbiter::clock_edge() {
    verilated_->reset_i = reset_i.read() ? 1 : 0;
    verilated_->take_i = take_i.read() ? 1 : 0;
    verilated_->start_i = start_i.read() ? 1 : 0;
    if (start_i.read()) {
        drive_table();
    }
    // The clock has fallen with the last request that changed, if there was one. An evaluation lets what follows from the
    // inputs settle before it looks at the clock.
    if (verilated_->clk_i != 0) {
        verilated_->clk_i = 0;
        verilated_->eval();
    }
    verilated_->clk_i = 1;
    verilated_->eval();
}

void BusArbiter::drive_table() {
    const FrontTable& table = table_i.read();
    verilated_->rows_i =
        static_cast<std::remove_reference_t<decltype(verilated_->rows_i)>>(table.rows.size());
    verilated_->slot_count_i = static_cast<SData>(table.slots.size());
    int slot = 0;
    for (const int row : table.slots) {
        put_slot(verilated_->slots_i, slot++, row);
    }
}

void BusArbiter::drive_requests() {
    std::uint64_t pending = 0;
    std::uint64_t ready = 0;
    for (std::size_t line = 0; line < pending_i.size(); ++line) {
        pending |= std::uint64_t{pending_i[line].read()} << line;
        ready |= std::uint64_t{ready_i[line].read()} << line;
    }
    using Lines = std::remove_reference_t<decltype(verilated_->pending_i)>;
    verilated_->pending_i = static_cast<Lines>(pending);
    verilated_->ready_i = static_cast<Lines>(ready);
    for (std::size_t line = 0; line < deadline_i.size(); ++line) {
        verilated_->deadline_i[line] = static_cast<EData>(deadline_i[line].read());
    }
}

void BusArbiter::drive_outputs() {
    const auto grants = static_cast<std::uint64_t>(verilated_->grant_o);
    for (std::size_t line = 0; line < grant_o.size() && grants != granted_; ++line) {
        grant_o[line].write((grants >> line & 1U) != 0);
    }
    granted_ = grants;
    grant_valid_o.write(verilated_->grant_valid_o != 0);
    search_o.write(verilated_->search_o != 0);
    lost_o.write(verilated_->lost_o != 0);
    recovered_o.write(verilated_->recovered_o);
    slot_o.write(verilated_->slot_o);
}

void BusArbiter::trace(sc_core::sc_trace_file* file) const {
    for (std::size_t line = 0; line < pending_i.size(); ++line) {
        sc_core::sc_trace(file, pending_i[line], path(numbered("pending", line).c_str()));
        sc_core::sc_trace(file, ready_i[line], path(numbered("ready", line).c_str()));
        sc_core::sc_trace(file, grant_o[line], path(numbered("grant", line).c_str()));
    }
    sc_core::sc_trace(file, start_i, path("start"));
    sc_core::sc_trace(file, take_i, path("take"));
    sc_core::sc_trace(file, grant_valid_o, path("grant_valid"));
    sc_core::sc_trace(file, search_o, path("search"));
    sc_core::sc_trace(file, lost_o, path("lost"));
    // Pins of the verilated module, which stay where they are in memory.
    sc_core::sc_trace(file, verilated_->recovered_o, path("recovered"), bits_for(kSlots - 1));
    sc_core::sc_trace(file, verilated_->slot_o, path("slot"), bits_for(kSlots - 1));
}

}  // namespace metabuffer::rtl
