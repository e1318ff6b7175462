/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* MPICH over UCX asks for messages without a pause. Where ranks outnumber cores, the rank that is to send then waits for a core
 * until the time slices of those that ask are over, some milliseconds a message. Loaded before the libraries, this gives the core
 * away after each question that was in vain. It changes no message. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>

unsigned ucp_worker_progress(void *worker) {
    static unsigned (*progress)(void *);
    if (!progress) {
        void *found = dlsym(RTLD_NEXT, "ucp_worker_progress");
        if (!found) {
            /* MPI itself was loaded at run time. */
            void *library = dlopen("libucp.so.0", RTLD_LAZY | RTLD_NOLOAD);
            found = library ? dlsym(library, "ucp_worker_progress") : 0;
        }
        if (!found) {
            fputs("waiting_ranks: UCX has no ucp_worker_progress; run without LD_PRELOAD\n", stderr);
            abort();
        }
        progress = (unsigned (*)(void *))found;
    }
    unsigned received = progress(worker);
    if (!received) {
        sched_yield();
    }
    return received;
}
