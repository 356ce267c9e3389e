// What the proofs of the bus arbiter assume and claim. Tables and requests are free choices, within docs/design.md:
// each row of a table has a slot, and each slot a row. Outputs as those of composer_proof.
module arbiter_proof #(
    parameter int LINES        = 3,
    parameter int SLOTS        = 5,
    parameter int GRANT_CYCLES = 0,
    localparam int LINE_BITS = $clog2(LINES),
    localparam int SLOT_BITS = $clog2(SLOTS),
    localparam int PLACE_BITS = 32
) (
    input logic clk_i,

    // The policy, of the first clock.
    input logic by_deadline_i,
    input logic lose_idle_i,
    input logic build_i,

    input logic                       start_i,
    input logic [LINE_BITS:0]         rows_i,
    input logic [SLOT_BITS:0]         slot_count_i,
    input logic [SLOTS*LINE_BITS-1:0] slots_i,
    input logic                       take_i,
    input logic [LINES-1:0]           pending_i,
    input logic [LINES-1:0]           ready_i,
    input logic [LINES*PLACE_BITS-1:0] deadline_i,
    input logic [LINE_BITS-1:0]       watched_i,  // a row whose wait is bounded

    output logic bad_grants,     // more than one grant, or not as grant_valid_o says
    output logic bad_requester,  // a grant to a row that did not ask
    output logic bad_idle,       // somebody asks, and nothing is granted, lost or searched for
    output logic bad_round,      // the watched row has waited longer than a round of the table
    output logic bad_order,      // by deadlines: not the earliest
    output logic bad,
    output logic seen_grant,
    output logic seen_recovered,
    output logic seen_lost,
    output logic seen_search,
    output logic seen_built,
    output logic seen_end_of_table,
    output logic seen_long_wait
);
  logic started = 1'b0;
  logic by_deadline, lose_idle, build;
  always_ff @(posedge clk_i) begin
    started <= 1'b1;
    if (!started) {by_deadline, lose_idle, build} <= {by_deadline_i, lose_idle_i, build_i};
  end

  // ---- the frame's table ----

  logic [LINES-1:0] has_slot;
  logic legal;
  always_comb begin : table_rules
    has_slot = '0;
    legal = rows_i <= (LINE_BITS + 1)'(LINES) && slot_count_i <= (SLOT_BITS + 1)'(SLOTS);
    for (int slot = 0; slot < SLOTS; slot = slot + 1) begin
      if ((SLOT_BITS + 1)'(slot) < slot_count_i) begin
        if ({1'b0, slots_i[slot*LINE_BITS+:LINE_BITS]} >= rows_i) legal = 1'b0;
        else has_slot[slots_i[slot*LINE_BITS+:LINE_BITS]] = 1'b1;
      end
    end
    for (int line = 0; line < LINES; line = line + 1) begin
      if ((LINE_BITS + 1)'(line) < rows_i && !has_slot[line] && !by_deadline) legal = 1'b0;
    end
  end

  logic start, take;

  logic [LINE_BITS:0] rows;
  logic [SLOT_BITS:0] slot_count;
  always_ff @(posedge clk_i) begin
    if (!started) begin
      rows <= '0;
      slot_count <= '0;
    end else if (start) begin
      rows <= rows_i;
      slot_count <= slot_count_i;
    end
  end

  logic [LINES-1:0] grant, asks;
  logic valid, search, lost;
  logic [SLOT_BITS-1:0] recovered, slot;
  for (genvar line = 0; line < LINES; line = line + 1) begin : gen_asks
    assign asks[line] = pending_i[line] && ready_i[line] && (LINE_BITS + 1)'(line) < rows;
  end

  // An answer is to the requests of the clock that decided, so many clocks before. The bus waits for it.
  logic [LINES-1:0] asked[GRANT_CYCLES+1];
  logic searching;
  assign asked[0] = asks;
  for (genvar stage = 0; stage < GRANT_CYCLES; stage = stage + 1) begin : gen_asked
    always_ff @(posedge clk_i) asked[stage+1] <= started ? asked[stage] : '0;
  end
  always_ff @(posedge clk_i) searching <= started && take && search;
  assign start = start_i && legal && !searching;
  assign take = take_i || searching;

  // ---- the watched row: slots used or lost while it asked all the time ----

  logic [LINE_BITS-1:0] watched;
  logic [SLOT_BITS+1:0] waited;
  always_ff @(posedge clk_i) begin
    if (!started) watched <= watched_i;
    if (!started || start || !asks[watched] || (take && grant[watched])) waited <= '0;
    else if (take && (valid || lost) && asked[GRANT_CYCLES][watched]) begin
      waited <= waited + (SLOT_BITS + 2)'(recovered) + 1'b1;
    end
  end

  assign bad_grants = started && ((grant & (grant - 1'b1)) != '0 || valid != (grant != '0) || (valid && lost));
  assign bad_requester = started && (grant & ~asked[GRANT_CYCLES]) != '0;
  assign bad_idle = started && take && !start && asks != '0 && !valid && !lost && !search;
  assign bad_round = started && !by_deadline && waited >= (SLOT_BITS + 2)'(slot_count) && asks[watched];
  // Of those that ask the earliest deadline wins, of equal ones the first row's.
  always_comb begin : deadlines
    bad_order = 1'b0;
    for (int winner = 0; winner < LINES; winner = winner + 1) begin
      for (int line = 0; line < LINES; line = line + 1) begin
        if (by_deadline && GRANT_CYCLES == 0 && started && grant[winner] && asks[line] &&
            (deadline_i[line*PLACE_BITS+:PLACE_BITS] < deadline_i[winner*PLACE_BITS+:PLACE_BITS] ||
             (line < winner &&
              deadline_i[line*PLACE_BITS+:PLACE_BITS] == deadline_i[winner*PLACE_BITS+:PLACE_BITS]))) begin
          bad_order = 1'b1;
        end
      end
    end
  end
  assign bad = bad_grants || bad_requester || bad_idle || bad_round || bad_order;

  assign seen_grant = started && valid;
  assign seen_recovered = started && valid && recovered != '0;
  assign seen_lost = started && lost;
  assign seen_search = started && search && !build;
  assign seen_built = started && search && build;
  assign seen_end_of_table = started && take && valid && slot + 1'b1 == slot_count &&
                             slot_count == (SLOT_BITS + 1)'(SLOTS);
  assign seen_long_wait = started && slot_count != '0 && waited == (SLOT_BITS + 2)'(slot_count) - 1'b1 && waited > 2;

  bus_arbiter #(
      .LINES(LINES),
      .SLOTS(SLOTS)
  ) arbiter (
      .clk_i,
      .reset_i(!started),
      .by_deadline_i(by_deadline),
      .lose_idle_i(lose_idle),
      .grant_cycles_i(8'(GRANT_CYCLES)),
      .build_i(build),
      .start_i(start),
      .rows_i,
      .slot_count_i,
      .slots_i,
      .take_i(take),
      .pending_i,
      .ready_i,
      .deadline_i,
      .grant_o(grant),
      .grant_valid_o(valid),
      .search_o(search),
      .lost_o(lost),
      .recovered_o(recovered),
      .slot_o(slot)
  );
endmodule
