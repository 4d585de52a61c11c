/* sandbox.h - what a worker may still ask of the kernel once it is up: memory, its own threads, its
 * socket to the front, and the descriptors that come over it. No file by name, no socket, no other
 * process, no signal to one, no code that it brought, no new privileges.
 *
 * A body that finds a hole in a decoder or a solver gets a process with nothing in reach. Three
 * layers, each of which would do: no privileges can be gained (no_new_privs), file names lead
 * nowhere (landlock, from Linux 5.13), system calls outside the list fail with EPERM (seccomp).
 * Test: http.sandbox.
 */
#ifndef SCATTERD_SANDBOX_H
#define SCATTERD_SANDBOX_H

#include <stdbool.h>

#include "fault.h"

/* Gives everything up for good; calls that are not allowed fail with EPERM from here on, clone3
 * with ENOSYS so that the C library takes clone. False with the reason where the kernel has no
 * seccomp; the layers that could be had are in force then. In a build with AddressSanitizer, which
 * needs /proc and ptrace for its reports, seccomp is left out and the rest is done. */
bool sandbox_enter(fault *why);

#endif
