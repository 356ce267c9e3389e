#include "rtl/table_unit.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "datapath/arbitration/arbitration_table.h"
#include "formats/slot_payload.h"
#include "lockstep/lockstep.h"
#include "support/random_seed.h"
#include "support/rows.h"
#include "support/traced_values.h"

namespace metabuffer::test::table_unit_test {
namespace {

using rtl::DecoderEvent;
using rtl::FrontTable;
using rtl::TableUnit;

constexpr int kDisplays = 4;

ViewportLimits limits() {
    ViewportLimits limits;
    limits.displays = kDisplays;
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

struct Setup {
    const char* name;
    Arbitration arbitration;
    SlotTableMaker slot_table;
};

/// Two tables, each row of which is known to be valid or not when it is made.
class Unit final : public Lockstep<TableUnit> {
  public:
    Unit(LockstepBench& bench, const Setup& setup)
        : Lockstep(bench, setup.name,
                   [&setup](const char* name, rtl::ClockGating) {
                       return std::make_unique<TableUnit>(name, bus_of(setup.arbitration, setup.slot_table),
                                                          limits());
                   }),
          setup_(setup) {}

    void stimulate() override {
        check_back();
        Random& random = bench_.random;
        event_ = DecoderEvent{};
        if (bench_.in_reset()) {
            script_.clear();
            return;
        }
        if (random.one_in(script_.empty() && !bench_.pausing() ? 4 : 60)) {
            if (script_.empty() && random.one_in(2)) {
                front_ = !front_;
            } else {
                make_pair();  // the one before may be cut off
            }
        }
        if (script_.empty()) return;
        event_ = script_.front();
        script_.pop_front();
    }
    void expect() override {
        table_ = bench_.in_reset() ? FrontTable{} : FrontTable{valid_rows(front()), slots_of(front())};
    }
    void edge() override {
        Given& given = back();
        if (event_->colour_start) given = {{}, {}, 0, sent_};
        if (event_->row) take_row(given, event_->table_row);
        given.bytes += event_->payload_bytes;
        counts_ = event_->row || event_->payload_bytes > 0;
    }
    void reset() override {
        tables_ = {};
        counts_ = true;
    }

    void check() const { CHECK(first_wrong_ == ""); }
    /// Between two edges: a waveform's numbers of rows and bytes, if the last edge may have changed them.
    void check_registers() {
        if (!counts_) return;
        const std::string rows = "back_rows[3]=" + std::to_string(valid_rows(back()).size());
        const std::string bytes = "back_slot_bytes[16]=" + std::to_string(back().bytes);
        INFO("clock " << bench_.clock());
        CHECK(traced_values(dut()) ==
              std::vector<std::string>{dut().name() + ("." + rows), dut().name() + ("." + bytes)});
    }

  private:
    /// The slots that the host sends, as indices of the rows that it sends.
    struct Sent {
        std::vector<int> slots;
        std::size_t bytes = 0;
        bool corrupt = false;
    };
    struct Given {
        ViewportTable rows;  ///< the dropped ones too
        std::vector<RowDefect> defects;
        std::size_t bytes = 0;  ///< of the slots, so far
        Sent sent;
    };

    Given& back() { return tables_[front_ ? 0 : 1]; }
    const Given& front() const { return tables_[front_ ? 1 : 0]; }

    /// A colour frame's start and rows, one a clock, and the payload of a depth frame.
    void make_pair() {
        Random& random = bench_.random;
        DecoderEvent start;
        start.colour_start = true;
        script_ = {start};
        for (int row = random.between(0, 5); row > 0; --row) {
            DecoderEvent with_row;
            with_row.row = true;
            with_row.table_row =
                table_row(random.between(1, 5), {5, 5}, {8, 8}, {3, 3}, random.between(1, 3));
            // Now and then a row again and again, for longer than it takes an idle block to sleep.
            script_.insert(script_.end(), random.one_in(8) ? 20U : 1U, with_row);
        }
        const auto rows = static_cast<int>(script_.size()) - 1;
        sent_ = Sent{};
        for (int row = 0; row < rows; ++row) {
            for (int slots = random.between(random.one_in(8) ? 0 : 1, 3); slots > 0; --slots) {
                sent_.slots.push_back(row);
            }
        }
        if (random.one_in(8)) sent_.slots.push_back(rows);  // no such row
        std::vector<std::uint8_t> payload;
        if (rows > 0 && !random.one_in(6))
            payload = encode_slots(sent_.slots, static_cast<std::size_t>(rows) + 1);
        sent_.corrupt = payload.empty() || random.one_in(8);
        if (sent_.corrupt && !payload.empty()) {
            if (random.one_in(2)) payload.pop_back();
            payload.front() = 'M';
        }
        sent_.bytes = payload.size();
        script_.insert(script_.end(), random.one_in(2) ? 20U : 0U, DecoderEvent{});
        for (std::size_t byte = 0; byte < payload.size(); ++byte) {
            if (byte % kLinkBytesPerPixel == 0) script_.emplace_back();
            DecoderEvent& event = script_.back();
            event.payload[event.payload_bytes++] = payload[byte];
        }
    }
    static void take_row(Given& given, const ViewportRow& row) {
        RowDefect defect = row.dcomp > kDisplays ? RowDefect::kDisplay : RowDefect::kNone;
        for (std::size_t i = 0; i < given.rows.size(); ++i) {
            const bool same = given.rows[i].dcomp == row.dcomp && given.defects[i] == RowDefect::kNone;
            if (same) defect = RowDefect::kDuplicate;
        }
        given.rows.push_back(row);
        given.defects.push_back(defect);
    }
    static ViewportTable valid_rows(const Given& given) {
        ViewportTable valid;
        for (std::size_t i = 0; i < given.rows.size(); ++i) {
            if (given.defects[i] == RowDefect::kNone) valid.push_back(given.rows[i]);
        }
        return valid;
    }
    /// The host's slots as indices of the valid rows; none if they are missing or wrong.
    static std::optional<std::vector<int>> sent_slots(const Given& given) {
        if (given.sent.corrupt || given.bytes < given.sent.bytes) return std::nullopt;
        std::vector<int> slots;
        std::set<int> owners;
        for (const int slot : given.sent.slots) {
            const auto at = static_cast<std::size_t>(slot);
            if (at >= given.rows.size() || given.defects[at] != RowDefect::kNone) return std::nullopt;
            slots.push_back(static_cast<int>(
                std::count(given.defects.begin(), given.defects.begin() + slot, RowDefect::kNone)));
            owners.insert(slots.back());
        }
        return owners.size() == valid_rows(given).size() ? std::optional(slots) : std::nullopt;
    }
    bool hosts() const {
        return setup_.slot_table == SlotTableMaker::kHost && setup_.arbitration != Arbitration::kEdf;
    }
    std::vector<int> slots_of(const Given& given) const {
        std::vector<int> slots;
        if (setup_.arbitration == Arbitration::kEdf) return slots;
        for (std::size_t row = 0; row < valid_rows(given).size(); ++row)
            slots.push_back(static_cast<int>(row));
        return hosts() ? sent_slots(given).value_or(slots) : slots;
    }

    /// Between two edges: what the block records of the back table.
    void check_back() {
        const Given& given = back();
        std::vector<std::pair<int, RowDefect>> dropped, due;
        for (const RejectedRow& row : dut().back_table().rejected)
            dropped.emplace_back(row.index, row.defect);
        for (std::size_t i = 0; i < given.rows.size(); ++i) {
            if (given.defects[i] != RowDefect::kNone) due.emplace_back(static_cast<int>(i), given.defects[i]);
        }
        const bool rejects = hosts() && !valid_rows(given).empty() && !sent_slots(given);
        bench_.happened["a row was dropped"] += due.empty() ? 0 : 1;
        bench_.happened["slots were rejected"] += rejects ? 1 : 0;
        bench_.happened["slots were taken"] += hosts() && !valid_rows(given).empty() && !rejects ? 1 : 0;
        const bool right = dut().back_table().rows == valid_rows(given) && dropped == due &&
                           dut().back_slots_rejected() == rejects;
        if (!right && first_wrong_.empty()) first_wrong_ = "clock " + std::to_string(bench_.clock());
    }

    const Setup& setup_;
    Input<DecoderEvent>& event_ = in(&TableUnit::event_i);
    Input<bool>& front_ = in(&TableUnit::front_i);
    Output<FrontTable>& table_ = out(&TableUnit::table_o);
    std::deque<DecoderEvent> script_;
    Sent sent_;
    std::array<Given, 2> tables_;  ///< by device
    bool counts_ = false;          ///< the last edge has taken a row or bytes, or was in reset
    std::string first_wrong_;
};

TEST_CASE("table unit: in lockstep with its reference") {
    static constexpr std::array kSetups{
        Setup{"host", Arbitration::kIrsa, SlotTableMaker::kHost},
        Setup{"built", Arbitration::kRoundRobin, SlotTableMaker::kBuilt},
        Setup{"deadlines", Arbitration::kEdf, SlotTableMaker::kHost},
    };
    LockstepBench bench(911);
    std::vector<std::unique_ptr<Unit>> units;
    for (const Setup& setup : kSetups) units.push_back(std::make_unique<Unit>(bench, setup));
    bench.clocks_to_reset = 100;
    const auto check = [&] { units.front()->check_registers(); };
    bench.run(20'000, 25, check,
              {{"a row was dropped", 100}, {"slots were rejected", 100}, {"slots were taken", 100}});
    for (const auto& unit : units) unit->check();
}

}  // namespace
}  // namespace metabuffer::test::table_unit_test
