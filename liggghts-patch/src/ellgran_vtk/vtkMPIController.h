/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * In place of VTK's header of this name: VTK's controller of processes, over the MPI that LIGGGHTS is built with. A VTK that comes
 * as a package is built with an MPI of its own, and two MPIs in one program do not work together.
 */

#ifndef ELLGRAN_VTK_MPI_CONTROLLER_H
#define ELLGRAN_VTK_MPI_CONTROLLER_H

#include <mpi.h>

#include <vtkAbstractArray.h>
#include <vtkCommunicator.h>
#include <vtkDummyController.h>
#include <vtkObjectFactory.h>

// VTK makes all its collective operations of these two.
class EllgranVTKCommunicator : public vtkCommunicator {
 public:
  vtkTypeMacro(EllgranVTKCommunicator, vtkCommunicator);
  static EllgranVTKCommunicator *New() { VTK_STANDARD_NEW_BODY(EllgranVTKCommunicator); }

  void use(MPI_Comm communicator)
  {
    mpi_ = communicator;
    MPI_Comm_rank(mpi_, &this->LocalProcessId);
    MPI_Comm_size(mpi_, &this->NumberOfProcesses);
    this->MaximumNumberOfProcesses = this->NumberOfProcesses;
  }

  MPI_Comm communicator() const { return mpi_; }

  // 1 if it was sent, 0 otherwise
  virtual int SendVoidArray(const void *data, vtkIdType length, int type, int remote, int tag)
  {
    const char *from = static_cast<const char *>(data);
    vtkIdType bytes = length * vtkAbstractArray::GetDataTypeSize(type);
    do {
      const int part = bytes < MOST_BYTES ? static_cast<int>(bytes) : static_cast<int>(MOST_BYTES);
      if (MPI_Send(const_cast<char *>(from), part, MPI_BYTE, remote, tag, mpi_) != MPI_SUCCESS) return 0;
      from += part;
      bytes -= part;
    } while (bytes > 0);
    return 1;
  }

  // as many as come, at most `length`; VTK asks for their number afterwards
  virtual int ReceiveVoidArray(void *data, vtkIdType length, int type, int remote, int tag)
  {
    char *to = static_cast<char *>(data);
    const int size = vtkAbstractArray::GetDataTypeSize(type);
    vtkIdType room = length * size, received = 0;
    int source = remote == vtkMultiProcessController::ANY_SOURCE ? MPI_ANY_SOURCE : remote;
    for (;;) {
      const int part = room < MOST_BYTES ? static_cast<int>(room) : static_cast<int>(MOST_BYTES);
      MPI_Status status;
      int came = 0;
      if (MPI_Recv(to, part, MPI_BYTE, source, tag, mpi_, &status) != MPI_SUCCESS) return 0;
      MPI_Get_count(&status, MPI_BYTE, &came);
      source = status.MPI_SOURCE;
      to += came;
      room -= came;
      received += came;
      // a part that is not full is the last
      if (came < MOST_BYTES || room == 0) break;
    }
    this->Count = received / size;
    return 1;
  }

 protected:
  EllgranVTKCommunicator() : mpi_(MPI_COMM_NULL) {}

 private:
  // of one message: MPI counts in int
  enum { MOST_BYTES = 1 << 30 };
  MPI_Comm mpi_;
};

// What LIGGGHTS asks of VTK's class of this name.
class vtkMPIController : public vtkDummyController {
 public:
  vtkTypeMacro(vtkMPIController, vtkDummyController);
  static vtkMPIController *New() { VTK_STANDARD_NEW_BODY(vtkMPIController); }

  using vtkDummyController::Initialize;
  void Initialize() { use(MPI_COMM_WORLD); }

  virtual vtkMPIController *PartitionController(int color, int key)
  {
    MPI_Comm part;
    MPI_Comm_split(static_cast<EllgranVTKCommunicator *>(this->Communicator)->communicator(), color, key, &part);
    vtkMPIController *const controller = vtkMPIController::New();
    controller->use(part);
    return controller;
  }

 protected:
  vtkMPIController() {}

 private:
  void use(MPI_Comm mpi)
  {
    EllgranVTKCommunicator *const communicator = EllgranVTKCommunicator::New();
    communicator->use(mpi);
    this->SetCommunicator(communicator);
    this->SetRMICommunicator(communicator);
    communicator->Delete();
  }
};

#endif
