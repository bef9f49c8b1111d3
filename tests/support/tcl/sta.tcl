# Stands for quartus_sta: runs a script with a design whose least slack is the environment's SLACK, in
# the second of its corners, and whose clocks are those of CLOCKS. Bits of Gray counters arrive apart
# by SKEW there.
#   tclsh sta.tcl FILE
proc project_open args {}
proc project_close args {}
proc create_timing_netlist args {}
proc read_sdc args {}
proc set_operating_conditions corner { set ::corner $corner }
proc update_timing_netlist args {}
proc get_available_operating_conditions {} { return {slow fast} }
proc foreach_in_collection {name collection body} { uplevel 1 [list foreach $name $collection $body] }
proc get_clocks args { return [expr {[lindex $args end] in $::env(CLOCKS) ? "one" : ""}] }
proc get_registers args { return "one" }
proc get_collection_size collection { llength $collection }
proc get_clock_domain_info kind {
    list [list core [expr {$::corner eq "fast" && $kind eq "-hold" ? $::env(SLACK) : 1.5}] 0]
}
proc get_path args {
    set spread [expr {$::corner eq "fast" ? $::env(SKEW) : 0.1}]
    return [expr {"-min_path" in $args ? "1.5 1.25" : "1.5 [expr {1.25 + $spread}]"}]
}
proc get_path_info {path option} { return $path }
proc qexit args { exit 3 }
source [lindex $argv 0]
