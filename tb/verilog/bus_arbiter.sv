// The bus arbiter of an input framebuffer: says whose burst the bus carries next. The answer is combinational, from the
// request lines and the slot pointer of the clock; the slot pointer and the frame's table are registers.
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
    input logic lose_idle_i,    // a slot that its owner cannot use: 1 its time passes, 0 the next that is ready has it

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
    output logic                 lost_o,
    output logic [SLOT_BITS-1:0] recovered_o,  // slots passed over on the way to the one granted
    output logic [SLOT_BITS-1:0] slot_o        // the slot pointer
);
  // ---- registers ----

  logic [LINE_BITS:0]         rows;
  logic [SLOT_BITS:0]         slot_count;
  logic [SLOTS*LINE_BITS-1:0] slots;

  // ---- who may have the bus ----

  logic [LINES-1:0] usable;
  always_comb begin : requests
    for (int line = 0; line < LINES; line++) begin
      usable[line] = pending_i[line] && ready_i[line] && (LINE_BITS + 1)'(line) < rows;
    end
  end

  // ---- by the slot table: the first usable slot, from the pointer on and round the table's end ----

  logic [SLOTS-1:0] usable_slot;
  logic found, found_behind;
  logic [SLOT_BITS-1:0] first_slot, first_slot_behind, granted_slot;
  always_comb begin : slot_search
    found = 1'b0;
    found_behind = 1'b0;
    first_slot = '0;
    first_slot_behind = '0;
    for (int slot = SLOTS - 1; slot >= 0; slot--) begin
      usable_slot[slot] = (SLOT_BITS + 1)'(slot) < slot_count && usable[slots[slot*LINE_BITS+:LINE_BITS]];
      if (usable_slot[slot]) begin
        found = 1'b1;
        first_slot = SLOT_BITS'(slot);
        if (SLOT_BITS'(slot) >= slot_o) begin
          found_behind = 1'b1;
          first_slot_behind = SLOT_BITS'(slot);
        end
      end
    end
    granted_slot = found_behind ? first_slot_behind : first_slot;
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

  // ---- the answer ----

  logic [LINE_BITS-1:0] granted_line;
  logic own_slot_usable;
  assign own_slot_usable = usable_slot[slot_o];
  always_comb begin : answer
    lost_o = 1'b0;
    recovered_o = '0;
    if (by_deadline_i) begin
      grant_valid_o = earliest_valid;
      granted_line = earliest_line;
    end else if (lose_idle_i) begin
      grant_valid_o = own_slot_usable;
      granted_line = slots[slot_o*LINE_BITS+:LINE_BITS];
      lost_o = !own_slot_usable && slot_count != '0;
    end else begin
      grant_valid_o = found;
      granted_line = slots[granted_slot*LINE_BITS+:LINE_BITS];
      // Round the end the sum may leave the pointer's width; what is left of it is right, for it is below slot_count.
      if (found) recovered_o = granted_slot - slot_o + (found_behind ? '0 : slot_count[SLOT_BITS-1:0]);
    end
    grant_o = '0;
    if (grant_valid_o) grant_o[granted_line] = 1'b1;
  end

  // ---- the slot pointer ----

  logic [SLOT_BITS-1:0] used_slot;
  assign used_slot = lose_idle_i ? slot_o : granted_slot;

  always_ff @(posedge clk_i) begin : pointer_and_table
    if (reset_i) begin
      rows <= '0;
      slot_count <= '0;
      slot_o <= '0;
    end else if (start_i) begin
      rows <= rows_i;
      slot_count <= slot_count_i;
      slots <= slots_i;
      slot_o <= '0;
    end else if (take_i && !by_deadline_i && (grant_valid_o || lost_o)) begin
      slot_o <= (SLOT_BITS + 1)'(used_slot) + 1'b1 == slot_count ? '0 : used_slot + 1'b1;
    end
  end
endmodule
