// The bus arbiter of an input framebuffer: decides whose burst the bus carries next. The answer is combinational, from
// the request lines and the slot pointer of the clock, or it is registered and stands some clocks later. The slot
// pointer and the frame's table are registers.
// docs/replacing-a-block.md says what the pins mean.
module bus_arbiter #(
    parameter  int LINES      = 16,  // rows that a frame's table may have, 2 or more
    parameter  int SLOTS      = 256 + LINES,  // slots that it may have: as many as the model's tables at most
    localparam int LINE_BITS  = $clog2(LINES),
    localparam int SLOT_BITS  = $clog2(SLOTS),
    localparam int PLACE_BITS = 32  // of a raster position
) (
    input logic clk_i,
    input logic reset_i,  // synchronous, active high

    // The policy: constant while reset is low.
    input logic by_deadline_i,  // 1: the earliest deadline first, no slots. 0: by the slot table
    input logic lose_idle_i,    // a slot that its owner cannot use: 1 its time passes, 0 the next that is ready gets it
    input logic [7:0] grant_cycles_i,  // edges from the one that decides to the answer; 0: combinational
    input logic build_i,               // 1: a frame's slot table takes a clock a slot

    // A frame's table, sampled at the edge that sees start_i.
    input logic                       start_i,
    input logic [LINE_BITS:0]         rows_i,        // 0..LINES
    input logic [SLOT_BITS:0]         slot_count_i,  // 0..SLOTS
    input logic [SLOTS*LINE_BITS-1:0] slots_i,       // the row that owns each slot, slot 0 lowest

    input logic                        take_i,  // the bus takes this clock's answer
    input logic [LINES-1:0]            pending_i,
    input logic [LINES-1:0]            ready_i,
    input logic [LINES*PLACE_BITS-1:0] deadline_i,  // line 0 lowest; only with by_deadline_i

    output logic [LINES-1:0]     grant_o,  // one-hot
    output logic                 grant_valid_o,
    output logic                 search_o,  // an answer is on its way
    output logic                 lost_o,
    output logic [SLOT_BITS-1:0] recovered_o,  // slots passed over on the way to the one granted
    output logic [SLOT_BITS-1:0] slot_o        // the slot pointer
);
  // ---- registers ----

  logic [LINE_BITS:0]         rows;
  logic [SLOT_BITS:0]         slot_count;
  logic [SLOTS*LINE_BITS-1:0] slots;

  logic [SLOT_BITS:0]         build_wait;  // slots of the table that are still to be made

  // What has been decided, and stands when search_wait has come to 0.
  logic                 found;
  logic [7:0]           search_wait;
  logic                 found_lost;
  logic [LINE_BITS-1:0] found_line;
  logic [SLOT_BITS-1:0] found_slot;
  logic [SLOT_BITS-1:0] found_recovered;

  // ---- who may have the bus ----

  logic [LINES-1:0] usable;
  always_comb begin : requests
    for (int line = 0; line < LINES; line++) begin
      usable[line] = pending_i[line] && ready_i[line] && (LINE_BITS + 1)'(line) < rows;
    end
  end

  // ---- by the slot table: the first usable slot, from the pointer on and round the table's end ----

  logic [SLOTS-1:0] usable_slot;
  logic any_slot, any_behind;
  logic [SLOT_BITS-1:0] first_slot, first_slot_behind, granted_slot;
  always_comb begin : slot_search
    any_slot = 1'b0;
    any_behind = 1'b0;
    first_slot = '0;
    first_slot_behind = '0;
    for (int slot = SLOTS - 1; slot >= 0; slot--) begin
      usable_slot[slot] = (SLOT_BITS + 1)'(slot) < slot_count && usable[slots[slot*LINE_BITS+:LINE_BITS]];
      if (usable_slot[slot]) begin
        any_slot = 1'b1;
        first_slot = SLOT_BITS'(slot);
        if (SLOT_BITS'(slot) >= slot_o) begin
          any_behind = 1'b1;
          first_slot_behind = SLOT_BITS'(slot);
        end
      end
    end
    granted_slot = any_behind ? first_slot_behind : first_slot;
  end

  // ---- by deadlines: the earliest, of equal ones that of the first row ----

  logic earliest_valid;
  logic [LINE_BITS-1:0] earliest_line;
  logic [PLACE_BITS-1:0] earliest;
  always_comb begin : deadline_search
    earliest_valid = 1'b0;
    earliest_line = '0;
    earliest = '1;
    for (int line = LINES - 1; line >= 0; line--) begin
      if (usable[line] && (!earliest_valid || deadline_i[line*PLACE_BITS+:PLACE_BITS] <= earliest)) begin
        earliest_valid = 1'b1;
        earliest_line = LINE_BITS'(line);
        earliest = deadline_i[line*PLACE_BITS+:PLACE_BITS];
      end
    end
  end

  // ---- what could be decided now ----

  logic candidate_valid, candidate_lost;
  logic [LINE_BITS-1:0] candidate_line;
  logic [SLOT_BITS-1:0] candidate_slot, candidate_recovered;
  logic own_slot_usable, built;
  assign own_slot_usable = usable_slot[slot_o];
  assign built = build_wait == '0;
  always_comb begin : candidate
    candidate_lost = 1'b0;
    candidate_recovered = '0;
    candidate_slot = slot_o;
    if (by_deadline_i) begin
      candidate_valid = earliest_valid && built;
      candidate_line = earliest_line;
    end else if (lose_idle_i) begin
      candidate_valid = own_slot_usable && built;
      candidate_line = slots[slot_o*LINE_BITS+:LINE_BITS];
      candidate_lost = !own_slot_usable && slot_count != '0 && built;
    end else begin
      candidate_valid = any_slot && built;
      candidate_line = slots[granted_slot*LINE_BITS+:LINE_BITS];
      candidate_slot = granted_slot;
      // Past the table's end the sum may exceed the pointer's width. Its low bits are right, since the result is below
      // slot_count.
      if (candidate_valid) begin
        candidate_recovered = granted_slot - slot_o + (any_behind ? '0 : slot_count[SLOT_BITS-1:0]);
      end
    end
  end

  // ---- the answer ----

  logic at_once, stands;
  logic [LINE_BITS-1:0] granted_line;
  logic [SLOT_BITS-1:0] used_slot;
  assign at_once = grant_cycles_i == '0;
  assign stands = found && search_wait == '0;
  assign search_o = !built || (!at_once && !stands && (found || candidate_valid || candidate_lost));
  always_comb begin : answer
    if (at_once) begin
      grant_valid_o = candidate_valid;
      lost_o = candidate_lost;
      granted_line = candidate_line;
      recovered_o = candidate_recovered;
      used_slot = candidate_slot;
    end else begin
      grant_valid_o = stands && !found_lost;
      lost_o = stands && found_lost;
      granted_line = found_line;
      recovered_o = stands ? found_recovered : '0;
      used_slot = found_slot;
    end
    grant_o = '0;
    if (grant_valid_o) grant_o[granted_line] = 1'b1;
  end

  always_ff @(posedge clk_i) begin : pointer_and_table
    if (reset_i) begin
      rows <= '0;
      slot_count <= '0;
      slot_o <= '0;
      build_wait <= '0;
    end else if (start_i) begin
      rows <= rows_i;
      slot_count <= slot_count_i;
      slots <= slots_i;
      slot_o <= '0;
      build_wait <= build_i ? slot_count_i : '0;
    end else begin
      if (!built) build_wait <= build_wait - 1'b1;
      if (take_i && !by_deadline_i && (grant_valid_o || lost_o)) begin
        slot_o <= (SLOT_BITS + 1)'(used_slot) + 1'b1 == slot_count ? '0 : used_slot + 1'b1;
      end
    end
  end

  always_ff @(posedge clk_i) begin : search
    if (reset_i) begin
      found <= 1'b0;
      search_wait <= '0;
    end else if (take_i && !start_i && !at_once) begin
      if (stands) begin
        found <= 1'b0;
      end else if (found) begin
        search_wait <= search_wait - 1'b1;
      end else if (candidate_valid || candidate_lost) begin
        found <= 1'b1;
        search_wait <= grant_cycles_i - 1'b1;
        found_lost <= candidate_lost;
        found_line <= candidate_line;
        found_slot <= candidate_slot;
        found_recovered <= candidate_recovered;
      end
    end
  end
endmodule
