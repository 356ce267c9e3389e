// A composer's part of the handshakes that start a frame: PIPEREADY goes up its display's pipeline, STARTFRAME comes
// down.
module pipeline_handshake (
    input logic clk_i,
    input logic reset_i,  // synchronous, active high

    input  logic pipemaster_i,  // strap, read in reset
    output logic pipemaster_o,  // as it was read
    input  logic moving_i,      // the column does not stand still
    input  logic startframe_i,
    output logic startframe_o,
    input  logic pipeready_i,   // from below
    output logic pipeready_o,   // to above

    input  logic running_i,
    input  logic running_next_i,
    input  logic fetched_next_i,  // the next frame can be composited
    output logic start_o,         // it starts at this edge
    output logic prefetched_o     // status, as of the composer
);
  logic prefetched_next;
  assign prefetched_next = !running_next_i && fetched_next_i;
  assign start_o = moving_i && !running_i && (pipemaster_o ? pipeready_o : startframe_i);

  always_ff @(posedge clk_i) begin : registers
    if (reset_i) begin
      pipemaster_o <= pipemaster_i;
      startframe_o <= 1'b0;
      pipeready_o <= 1'b0;
      prefetched_o <= 1'b0;
    end else begin
      if (moving_i) startframe_o <= start_o;
      // A PIPEREADY from below that belongs to the frame just composited may still stand at the frame's last edge.
      pipeready_o <= !running_next_i && !running_i && !(moving_i ? start_o : startframe_o) &&
                     (pipeready_o || (prefetched_next && pipeready_i));
      prefetched_o <= prefetched_next;
    end
  end
endmodule
