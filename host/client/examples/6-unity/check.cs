// Prints sizes and offsets as check.c does; with a scene it presses, too.
using System;
using System.Runtime.InteropServices;
using System.Threading;
using Chaincell;

static class Program
{
    static void Print<T>(string name, params string[] fields)
    {
        Console.Write($"{name} {Marshal.SizeOf(typeof(T))}");
        foreach (var field in fields)
        {
            Console.Write($" {Marshal.OffsetOf(typeof(T), field)}");
        }
        Console.WriteLine();
    }

    static void Main(string[] words)
    {
        Console.WriteLine($"version {Session.Version}");
        Print<ToolPose>("pose", "X", "Qx", "Engaged", "OpeningTurnsQ16");
        Print<ToolOutput>("output", "ForceX", "TorqueX", "Contacts", "Flags");
        Print<Options>("options", "Role", "Wait", "ServerWaitNs", "WatchdogMs", "RampMs");
        Print<Answer>("answer", "Tick", "SessionId", "ForceTick", "StateHash", "RoundTripNs", "AgeNs", "Answers",
            "EnergyJ", "Flags", "Notes", "StepNs", "Sweeps", "Tool0", "Tool1", "ForceError0N", "ForceError7N",
            "TorqueError0NM", "TorqueError7NM");
        if (words.Length == 0)
        {
            return;
        }
        float largest = 0;
        using (var session = new Session(words[0], 0, 0))
        {
            var answer = new Answer();
            for (int tick = 0; tick < 1500; ++tick)
            {
                var pose = ToolPose.FromUnity(0, -0.00002f * tick, 0, 0, 0, 0, 1, tick > 0);
                answer = session.Step(new[] { pose }, 1000000000);
                answer.Tool0.ForceToUnity(out var x, out var y, out var z);
                largest = Math.Max(largest, y);
                Thread.Sleep(1);  // a hand has a clock of its own, and the server drops poses that come too fast
            }
            Console.WriteLine($"tick {answer.Tick}: state hash {answer.StateHash:x16}");
            Console.WriteLine($"{answer.Answers} answers, largest force {largest:F9} N");
        }
    }
}
