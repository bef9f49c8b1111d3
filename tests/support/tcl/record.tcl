# Runs a Tcl file with the commands of one Quartus tool replaced by ones that record their
# arguments; any other command fails as it would there.
#   tclsh record.tcl KIND FILE        prints a line per call, words separated by 0x1f

set commands(hw) {set_module_property add_fileset set_fileset_property add_fileset_file
    add_interface set_interface_property add_interface_port set_module_assignment
    add_parameter set_parameter_property}
set commands(qsys) {create_system set_project_property add_instance
    set_instance_parameter_value add_connection set_connection_parameter_value add_interface
    set_interface_property save_system}
set commands(qsf) {set_global_assignment set_location_assignment set_instance_assignment}
set commands(sdc) {create_clock create_generated_clock derive_pll_clocks
    derive_clock_uncertainty set_input_delay set_output_delay set_false_path set_clock_groups
    set_multicycle_path set_net_delay get_ports get_clocks get_pins get_nets get_registers}

proc report {name arguments} {
    puts [join [concat [list $name] $arguments] \x1f]
}
lassign $argv kind file
foreach name $commands($kind) {
    # A collection stands for what it was asked for.
    proc $name args "report $name \$args; return \"<[string range $name 4 end] \$args>\""
}
# `package require -exact qsys` is for Quartus only.
rename package tcl_package
proc package args {
    if {[lrange $args 0 2] eq {require -exact qsys}} { report package $args; return }
    tcl_package {*}$args
}
# Of Tcl itself, a generated file needs `set` only.
foreach name {exec open file socket exit glob cd} { catch {rename $name {}} }
source $file
