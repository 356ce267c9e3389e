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

  logic [SLOTS-1:0] usable_slots, slots_behind, candidate_slots, earlier_slots, first_slot;
  logic any_behind, slot_valid;
  logic [SLOT_BITS-1:0] granted_slot;
  logic [LINE_BITS-1:0] slot_line;
  always_comb begin : slot_search
    for (int slot = 0; slot < SLOTS; slot++) begin
      usable_slots[slot] = (SLOT_BITS + 1)'(slot) < slot_count && usable[slots[slot*LINE_BITS+:LINE_BITS]];
    end
    slots_behind = usable_slots & ({SLOTS{1'b1}} << slot_o);
    any_behind = slots_behind != '0;
    if (lose_idle_i) candidate_slots = usable_slots & (SLOTS'(1) << slot_o);
    else candidate_slots = any_behind ? slots_behind : usable_slots;
    slot_valid = candidate_slots != '0;
    // Doubling the distance looks at all slots before each one in a few steps.
    earlier_slots = candidate_slots << 1;
    for (int distance = 1; distance < SLOTS; distance = 2 * distance) begin
      earlier_slots = earlier_slots | earlier_slots << distance;
    end
    first_slot = candidate_slots & ~earlier_slots;
    granted_slot = '0;
    slot_line = '0;
    for (int slot = 0; slot < SLOTS; slot++) begin
      if (first_slot[slot]) begin
        granted_slot = granted_slot | SLOT_BITS'(slot);
        slot_line = slot_line | slots[slot*LINE_BITS+:LINE_BITS];
      end
    end
  end

  // ---- by deadlines: the earliest, of equal ones that of the first row ----

  // A tree: node n has the earlier of nodes 2 n and 2 n + 1, and the last LEAVES nodes are the rows.
  localparam int LEAVES = 1 << LINE_BITS;
  logic [2*LEAVES-1:1] earliest_valid;
  logic [2*LEAVES*LINE_BITS-1:LINE_BITS] earliest_line;
  logic [2*LEAVES*PLACE_BITS-1:PLACE_BITS] earliest;
  always_comb begin : deadline_search
    for (int line = 0; line < LEAVES; line++) begin
      earliest_valid[LEAVES+line] = line < LINES ? usable[line] : 1'b0;
      earliest_line[(LEAVES+line)*LINE_BITS+:LINE_BITS] = LINE_BITS'(line);
      earliest[(LEAVES+line)*PLACE_BITS+:PLACE_BITS] = line < LINES ? deadline_i[line*PLACE_BITS+:PLACE_BITS] : '1;
    end
    for (int node = LEAVES - 1; node > 0; node--) begin
      earliest_valid[node] = earliest_valid[2*node] || earliest_valid[2*node+1];
      earliest_line[node*LINE_BITS+:LINE_BITS] = earliest_line[(2*node+1)*LINE_BITS+:LINE_BITS];
      earliest[node*PLACE_BITS+:PLACE_BITS] = earliest[(2*node+1)*PLACE_BITS+:PLACE_BITS];
      if (earliest_valid[2*node] &&
          (!earliest_valid[2*node+1] ||
           earliest[2*node*PLACE_BITS+:PLACE_BITS] <= earliest[(2*node+1)*PLACE_BITS+:PLACE_BITS])) begin
        earliest_line[node*LINE_BITS+:LINE_BITS] = earliest_line[2*node*LINE_BITS+:LINE_BITS];
        earliest[node*PLACE_BITS+:PLACE_BITS] = earliest[2*node*PLACE_BITS+:PLACE_BITS];
      end
    end
  end

  // ---- what could be decided now ----

  logic built, candidate_valid, candidate_lost;
  logic [LINE_BITS-1:0] candidate_line;
  logic [SLOT_BITS-1:0] candidate_slot, candidate_recovered;
  assign built = build_wait == '0;
  always_comb begin : candidate
    candidate_valid = built && (by_deadline_i ? earliest_valid[1] : slot_valid);
    candidate_lost = built && !by_deadline_i && lose_idle_i && !slot_valid && slot_count != '0;
    candidate_line = by_deadline_i ? earliest_line[LINE_BITS+:LINE_BITS] : slot_line;
    candidate_slot = lose_idle_i ? slot_o : granted_slot;
    candidate_recovered = '0;
    // Past the table's end the sum may exceed the pointer's width. Its low bits are right, since the result is below
    // slot_count.
    if (candidate_valid && !by_deadline_i && !lose_idle_i) begin
      candidate_recovered = granted_slot - slot_o + (any_behind ? '0 : slot_count[SLOT_BITS-1:0]);
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
