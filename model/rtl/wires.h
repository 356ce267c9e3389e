#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "rtl/signals.h"
#include "rtl/wire.h"
#include "scenario/scenario.h"
#include "simulation/numbered.h"

namespace metabuffer::rtl {

using metabuffer::numbered;

/// A row of signals of one kind.
template <typename Value>
class SignalArray {
  public:
    /// Makes `count` signals, each named by its index and with the initial value.
    template <typename NameOf>
    SignalArray(std::size_t count, NameOf name_of, const Value& initial = Value{}) {
        for (std::size_t i = 0; i < count; ++i) {
            signals_.push_back(std::make_unique<Wire<Value>>(name_of(i).c_str(), initial));
        }
    }
    sc_core::sc_signal<Value>& operator[](std::size_t i) { return *signals_[i]; }
    std::size_t size() const { return signals_.size(); }

  private:
    std::vector<std::unique_ptr<Wire<Value>>> signals_;
};

/// Every wire between two blocks, with the paper's name where it has one, as the block that reads the wire sees it. The
/// pipeline wires of display d run from PIPE_1_d, above the top composer, to PIPE_(M+1)_d: composer r, from 1, drives
/// PIPE_(r+1)_d and STARTFRAME_(r+1)_d, and PIPEREADY_r_d to the composer above.
struct Wires {
    /// bus_registers: whether registers lie between each input framebuffer and its composers. layer: of the links.
    Wires(std::size_t renderers, std::size_t displays, bool bus_registers = false,
          LinkLayer layer = LinkLayer::kPixel)
        : link_in(renderers, name_of("DVI_IN")),
          clock_ppm(renderers, name_of("CLOCK_PPM")),
          disturbance(renderers, name_of("DISTURBANCE")),
          tmds_in(layer == LinkLayer::kTmds ? renderers : 0, name_of("TMDS_IN")),
          pixel(renderers, name_of("PIXEL")),
          event(renderers, name_of("EVENT")),
          pair_request(renderers, name_of("PAIR_REQUEST")),
          bus(renderers, name_of("BUS")),
          pipemaster(renderers, name_of("PIPEMASTER")),
          busready(renderers * displays, name_of("BUSREADY", displays)),
          tableready(renderers * displays, name_of("TABLEREADY", displays)),
          stall(renderers * displays, name_of("STALL", displays)),
          pipe((renderers + 1) * displays, name_of("PIPE", displays)),
          startframe((renderers + 1) * displays, name_of("STARTFRAME", displays)),
          pipeready((renderers + 1) * displays, name_of("PIPEREADY", displays)),
          column_stall(displays, name_of("COLUMNSTALL")),
          framedone(displays, name_of("FRAMEDONE")),
          framebad(displays, name_of("FRAMEBAD")),
          link_out(displays, name_of("DVI_OUT")),
          tmds_out(layer == LinkLayer::kTmds ? displays : 0, name_of("TMDS_OUT")),
          link_in_before_(tmds_in.size(), name_of("DVI_IN_driven")),
          link_out_before_(tmds_out.size(), name_of("DVI_OUT_driven")),
          tmds_in_before_(tmds_in.size()),
          bus_before_(bus_registers ? renderers : 0, name_of("BUS_driven")),
          busready_behind_(bus_registers ? renderers * displays : 0, name_of("BUSREADY_read", displays)),
          tableready_behind_(bus_registers ? renderers * displays : 0, name_of("TABLEREADY_read", displays)),
          own_bus_(renderers * displays) {}

    static std::function<std::string(std::size_t)> name_of(const char* stem) {
        return [stem](std::size_t i) { return numbered(stem, i); };
    }
    static std::function<std::string(std::size_t)> name_of(const char* stem, std::size_t displays) {
        return [stem, displays](std::size_t i) { return numbered(stem, i / displays, i % displays); };
    }

    /// The bus as composer i (renderer * displays + display) sees it: its renderer's, unless a fault lies between.
    sc_core::sc_signal<BusBeat>& bus_seen_by(std::size_t i) {
        return own_bus_[i] ? *own_bus_[i] : bus[i / framedone.size()];
    }
    /// From now on composer i sees its own bus, which the caller drives.
    sc_core::sc_signal<BusBeat>& own_bus(std::size_t i) {
        if (!own_bus_[i]) {
            const std::size_t displays = framedone.size();
            own_bus_[i] =
                std::make_unique<Wire<BusBeat>>(numbered("BUS", i / displays, i % displays).c_str());
        }
        return *own_bus_[i];
    }

    /// A link as the source or the output framebuffer drives it: link_in or link_out, unless an encoder and a decoder lie
    /// between.
    sc_core::sc_signal<DviLink>& link_in_driven(std::size_t renderer) {
        return link_in_before_.size() > 0 ? link_in_before_[renderer] : link_in[renderer];
    }
    sc_core::sc_signal<DviLink>& link_out_driven(std::size_t display) {
        return link_out_before_.size() > 0 ? link_out_before_[display] : link_out[display];
    }
    /// The characters as a renderer's encoder drives them: what the decoder sees, unless a fault lies between.
    sc_core::sc_signal<TmdsLink>& tmds_in_driven(std::size_t renderer) {
        return tmds_in_before_[renderer] ? *tmds_in_before_[renderer] : tmds_in[renderer];
    }
    /// From now on a renderer's encoder drives its own wire, and the caller the one that the decoder sees.
    sc_core::sc_signal<TmdsLink>& own_tmds_in(std::size_t renderer) {
        if (!tmds_in_before_[renderer]) {
            tmds_in_before_[renderer] =
                std::make_unique<Wire<TmdsLink>>(numbered("TMDS_IN_driven", renderer).c_str());
        }
        return *tmds_in_before_[renderer];
    }

    /// BUS as the input framebuffer drives it, BUSREADY and TABLEREADY as it reads them: bus, busready and tableready,
    /// unless registers lie between.
    sc_core::sc_signal<BusBeat>& bus_driven(std::size_t renderer) {
        return bus_before_.size() > 0 ? bus_before_[renderer] : bus[renderer];
    }
    sc_core::sc_signal<bool>& busready_read(std::size_t i) {
        return busready_behind_.size() > 0 ? busready_behind_[i] : busready[i];
    }
    sc_core::sc_signal<bool>& tableready_read(std::size_t i) {
        return tableready_behind_.size() > 0 ? tableready_behind_[i] : tableready[i];
    }

    SignalArray<DviLink> link_in;
    SignalArray<int> clock_ppm;                ///< how far a fault puts the link's clock off
    SignalArray<TmdsDisturbance> disturbance;  ///< what faults do to the link's characters
    SignalArray<TmdsLink> tmds_in;             ///< of links with characters
    SignalArray<DecodedPixel> pixel;
    SignalArray<DecoderEvent> event;
    SignalArray<bool> pair_request;
    SignalArray<BusBeat> bus;
    SignalArray<bool> pipemaster;
    SignalArray<bool> busready;
    SignalArray<bool> tableready;
    SignalArray<bool> stall;
    SignalArray<PipePixel> pipe;
    SignalArray<bool> startframe;
    SignalArray<bool> pipeready;  ///< wire r is raised by composer r, the last one by the output framebuffer
    SignalArray<bool> column_stall;
    SignalArray<bool> framedone;
    SignalArray<bool> framebad;
    SignalArray<DviLink> link_out;
    SignalArray<TmdsLink> tmds_out;  ///< of links with characters
    Wire<bool> swaplock{"SWAPLOCK"};
    Wire<bool> swapskip{"SWAPSKIP"};

  private:
    SignalArray<DviLink> link_in_before_;  ///< before the encoder
    SignalArray<DviLink> link_out_before_;
    std::vector<std::unique_ptr<sc_core::sc_signal<TmdsLink>>>
        tmds_in_before_;               ///< before the fault, where there is one
    SignalArray<BusBeat> bus_before_;  ///< before the registers
    SignalArray<bool> busready_behind_;
    SignalArray<bool> tableready_behind_;
    std::vector<std::unique_ptr<sc_core::sc_signal<BusBeat>>> own_bus_;
};

}  // namespace metabuffer::rtl
